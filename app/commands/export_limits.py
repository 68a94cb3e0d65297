"""Refuses flags without effect on what is exported, and outputs among the model's own files."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from app.commands.export_kinds import KINDS
from app.commands.outside import require_no_overwriting, require_outside
from app.commands.view_selection import Moment
from app.errors import UserError
from app.exports.meshes.writing import CLIPS
from app.scenes.scene import Scene
from renderer.listing import listed

MOMENTS: Final = ("frames", "time", "path")


def outputs(flags: argparse.Namespace) -> Iterator[tuple[str, Path]]:
    """The flag and the path of each export that is asked for."""
    for name in KINDS:
        if (path := getattr(flags, name)) is not None:
            yield name, path


def check(flags: argparse.Namespace) -> None:
    """Raises UserError: nothing is asked for, the name of another format, or a flag without effect."""
    asked = dict(outputs(flags))
    if not asked:
        *most, last = (f"{flag(name)} {kind.metavar}" for name, kind in KINDS.items())
        raise UserError(f"expected what to export: {', '.join(most)} or {last}")
    for name, path in asked.items():
        suffix = "" if KINDS[name].is_splat_folder else KINDS[name].suffix
        if suffix and path.suffix.lower() != suffix:
            kind = f"an {suffix}" if suffix == ".html" else f"a {suffix}"
            raise UserError(f"{flag(name)}: expected the name of {kind} file, got {path.name or path}")
    whole = [name for name, path in asked.items() if KINDS[name].is_whole or _is_film(name, path)]
    for name in MOMENTS:
        if whole and getattr(flags, name) is not None:
            raise UserError(
                f"{flag(name)}: {flag(whole[0])} holds all of the clip; export it without this flag"
            )
    for name in dict.fromkeys(name for kind in KINDS.values() for name in kind.heeds):
        heeding = [one for one, kind in KINDS.items() if name in kind.heeds]
        if getattr(flags, name) != flags.default_of(name) and not set(heeding) & set(asked):
            which = listed([flag(one) for one in heeding])
            raise UserError(f"{flag(name)}: expected an export that it applies to, such as {which}")
    if flags.frames_per_second is not None and flags.path is None and not goes_through_time(flags):
        raise UserError("--frames-per-second: expected an export through time, such as --video, or --path")


def require_apart(flags: argparse.Namespace, scene: Scene) -> None:
    """Raises UserError: a place among the files that the scene is made of, or that it is itself."""
    for name, path in outputs(flags):
        require_outside(flag(name), path, scene)
        require_no_overwriting(flag(name), path, scene)


def goes_through_time(flags: argparse.Namespace) -> bool:
    """Whether any of what is asked for plays at a speed: a file of all of the clip, or a video."""
    return any(
        KINDS[name].is_whole or name == "video" or _is_film(name, path) for name, path in outputs(flags)
    )


def require_one_camera(flags: argparse.Namespace, wanted: Sequence[Moment]) -> None:
    """Raises UserError: a page is asked for, of several cameras."""
    # Frames are seen by one camera, several cameras at one moment.
    if flags.html and flags.camera and len(wanted) > 1 and wanted[0].frame is None:
        raise UserError(f"--html: expected one --camera, got {len(wanted)}: {flags.camera}")


def require_movement(flags: argparse.Namespace, scene: Scene) -> None:
    """Raises UserError: what shows one tissue as it moves is asked for, of other models."""
    if any(KINDS[name].is_of_tissue for name, _ in outputs(flags)):
        scene.require_same_tissue()


def flag(name: str) -> str:
    """The flag of that name as it is typed."""
    return "--with" if name == "renderer" else f"--{name.replace('_', '-')}"


def _is_film(name: str, path: Path) -> bool:
    return name == "mesh" and path.suffix.lower() in CLIPS
