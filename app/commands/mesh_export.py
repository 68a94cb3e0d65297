"""`vesselsplat export RUN --mesh FILE.glb|FILE.usdc|DIR`: the tissue surface as a mesh that moves."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from app.commands.view_selection import Moment
from app.console.older_files import say_older
from app.console.progress import progress
from app.errors import UserError
from app.exports.make import make
from app.exports.meshes.film import windows_left
from app.exports.meshes.mesh_text import MOMENTS
from app.exports.meshes.of_scene import surface_mesh
from app.exports.meshes.writing import CLIPS
from app.exports.records import LEAST_FACES, MOST_COARSE, MOST_FINE
from app.exports.sources import Opened
from app.exports.usd_file import require_usd
from app.files.atomic import filled
from app.files.stepping import run_to_end
from app.scenes.scene import Scene
from app.scenes.surfaces import surface_of_window
from renderer.model_windows import ModelWindow, window_at
from renderer.surface.fineness import VERTICES, Fineness
from renderer.surface.mesh import Mesh


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--mesh-format",
        choices=[suffix[1:] for suffix in MOMENTS],
        default="ply",
        help="of the files in that folder (default ply)",
    )
    parser.add_argument(
        "--vertices",
        type=int,
        default=VERTICES,
        metavar="N",
        help=f"about how many vertices the mesh has for a frame full of tissue (default {VERTICES})",
    )
    parser.add_argument(
        "--faces",
        type=int,
        metavar="N",
        help="simplify it to so many triangles (needs fast-simplification)",
    )


def check(flags: argparse.Namespace) -> None:
    """Raises UserError for a number, or a file, that no mesh has."""
    if flags.mesh is None:
        return
    if flags.mesh.suffix and flags.mesh.suffix.lower() not in CLIPS and not flags.mesh.is_dir():
        raise UserError(f"--mesh: expected a .glb or .usdc file, or a folder, got {flags.mesh.name}")
    if flags.mesh.suffix.lower() == ".usdc":
        require_usd()
    if not MOST_COARSE <= flags.vertices <= MOST_FINE:
        raise UserError(f"--vertices: expected {MOST_COARSE} to {MOST_FINE}, got {flags.vertices}")
    if flags.faces is not None and flags.faces < LEAST_FACES:
        raise UserError(f"--faces: expected at least {LEAST_FACES}, got {flags.faces}")


def require(flags: argparse.Namespace, scene: Scene, wanted: Sequence[Moment]) -> None:
    """Raises UserError: there is no surface at one of the moments, or in one of the windows, that are asked
    for. They are worked out for it, and remembered."""
    if flags.mesh is None:
        return
    scene.require_same_tissue()
    for window in _windows(flags, scene, wanted):
        surface_of_window(scene, window, Fineness(flags.vertices, flags.faces))


def _windows(flags: argparse.Namespace, scene: Scene, wanted: Sequence[Moment]) -> tuple[ModelWindow, ...]:
    """Those whose surface goes into the file or the folder, in the order in which they do."""
    if flags.mesh.suffix.lower() in CLIPS:
        return windows_left(scene.model)
    asked = (window_at(scene.model, one.time) for one in wanted)
    return tuple({window.index: window for window in asked}.values())


def write(flags: argparse.Namespace, scene: Scene, wanted: Sequence[Moment], speed: float) -> None:
    """A folder has the moments that are asked for, a file all of the clip."""
    path: Path = flags.mesh
    windows = _windows(flags, scene, wanted)
    said = _size(surface_of_window(scene, windows[0], Fineness(flags.vertices, flags.faces)).mesh)
    if path.suffix.lower() in CLIPS:
        _write_file(flags, scene, speed)
        several = f"{len(windows)} meshes, one after the other, the first of {said}"
        meshes = several if len(windows) > 1 else said
        sys.stdout.write(f"{path}: {meshes}, {path.stat().st_size / 1e6:.1f} MB\n")
    else:
        _write_folder(flags, scene, wanted, speed)
        others = ", the first" if scene.split_by_time else ""
        meshes = "1 mesh" if len(wanted) == 1 else f"{len(wanted)} meshes"
        sys.stdout.write(f"{path}: {meshes}{others} of {said}\n")


def _size(mesh: Mesh) -> str:
    return f"{len(mesh.vertices)} vertices, {len(mesh.faces)} triangles"


def _write_file(flags: argparse.Namespace, scene: Scene, speed: float) -> None:
    fineness = {"vertices": flags.vertices, "faces": flags.faces}
    record = surface_mesh(scene, speed, **fineness)
    with progress("export", len(scene.cameras)) as report:
        for done in make(record, Opened(model=scene), flags.mesh):
            report(done, flags.mesh.name)


def _write_folder(flags: argparse.Namespace, scene: Scene, wanted: Sequence[Moment], speed: float) -> None:
    sources, fineness = Opened(model=scene), {"vertices": flags.vertices, "faces": flags.faces}
    with filled(flags.mesh) as staging, progress("export", len(wanted)) as report:
        for done, one in enumerate(wanted, start=1):
            record = surface_mesh(scene, speed, one.frame, one.time, **fineness)
            run_to_end(make(record, sources, staging / f"{one.name}.{flags.mesh_format}"))
            report(done, one.name)
    say_older(flags.mesh, [f"{one.name}.{flags.mesh_format}" for one in wanted])
