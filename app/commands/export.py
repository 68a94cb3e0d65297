"""`vesselsplat export RUN --ply|--spz|--sog|--glb DIR | --mesh FILE|DIR | --npz|--tracks FILE |
--video|--html FILE | --cameras FILE|DIR`: a model for others."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from app.commands import (
    camera_export,
    export_limits,
    mesh_export,
    research_export,
    view_flags,
    view_selection,
)
from app.commands.export_kinds import KINDS
from app.commands.view_selection import Moment
from app.console.older_files import say_older
from app.console.progress import progress
from app.errors import UserError
from app.exports.browser.of_scene import browser_model, far_off
from app.exports.make import make
from app.exports.records import MovingSplats, RenderVideo, Splats
from app.exports.replay.recorded import recorded
from app.exports.sources import Opened
from app.exports.splats import fourdgs
from app.exports.splats.writing import CLIPPED, MOVING, layout_of
from app.files.atomic import filled
from app.files.codecs import CODECS, ending_of
from app.files.records import extended
from app.files.stepping import run_to_end
from app.scenes.clip_speed import FRAMES_PER_SECOND, clip_speed
from app.scenes.drawer import Drawer
from app.scenes.observed import observed
from app.scenes.records import MomentRecord
from app.scenes.renderers import drawer
from app.scenes.scene import Scene
from app.scenes.view_request import ViewRequest, drawn_record
from renderer.harmonics import BANDS
from renderer.listing import count


def add_flags(parser: argparse.ArgumentParser) -> None:
    for name, kind in KINDS.items():
        parser.add_argument(export_limits.flag(name), type=Path, metavar=kind.metavar, help=kind.text)
    parser.add_argument(
        "--sh-degree",
        type=int,
        choices=range(len(BANDS)),
        metavar="D",
        help="degree of the splat files' spherical harmonics, 0 to 3, padded with zeros (default the "
        "model's): the original viewer of 3D Gaussian Splatting reads degree 3 only",
    )
    parser.add_argument(
        "--without-unobserved",
        action="store_true",
        help="splat files leave out Gaussians behind tissue in all frames, as side views do; from where the "
        "endoscope was, holes appear at outlines",
    )
    mesh_export.add_flags(parser)
    camera_export.add_flags(parser)
    research_export.add_flags(parser)
    view_selection.add_flags(parser)
    view_flags.add_flag(parser)
    parser.set_defaults(default_of=parser.get_default)


def run(flags: argparse.Namespace) -> None:
    export_limits.check(flags)
    if flags.video and not ending_of(flags.video):
        endings = ", ".join(CODECS)
        raise UserError(f"--video: expected a name that ends in {endings}, got {flags.video.name}")
    mesh_export.check(flags)
    camera_export.check(flags)
    moving = [path for name in ("usd", "4dgs") if (path := getattr(flags, name)) is not None]
    for path in moving:
        require_package, _ = MOVING[path.suffix.lower()]
        require_package()
    research_export.check(flags)
    scene, wanted = view_selection.chosen(flags)
    export_limits.require_apart(flags, scene)
    export_limits.require_one_camera(flags, wanted)
    export_limits.require_movement(flags, scene)
    # What may be refused yet comes before the first file is written.
    pen = drawer(flags.renderer)
    views = view_flags.asked_for(flags, scene, wanted) if flags.video else []
    speed, kept = _speed(flags, scene, wanted), observed(scene) if flags.without_unobserved else scene
    mesh_export.require(flags, scene, wanted)
    research_export.write(flags, scene, wanted, pen)
    for name, path in export_limits.outputs(flags):
        if KINDS[name].is_splat_folder:
            _write_splats(path, KINDS[name].suffix, scene, kept, wanted, flags.sh_degree)
    if flags.video:
        _write_video(flags.video, views, pen, wanted, speed)
    if flags.html:
        _write_page(flags.html, scene, wanted, speed, beyond=flags.unobserved)
    for path in moving:
        _write_moving(path, scene, kept, speed)
    if flags.mesh:
        mesh_export.write(flags, scene, wanted, speed)
    if flags.cameras:
        camera_export.write(flags, scene, wanted)


def _speed(flags: argparse.Namespace, scene: Scene, wanted: list[Moment]) -> float:
    """Frames a second: as the flag asks, through a clip its own. That they are assumed is told on stderr."""
    if flags.frames_per_second is not None:
        return float(flags.frames_per_second)
    if not export_limits.goes_through_time(flags) or wanted[0].frame is None or len(scene.cameras) == 1:
        return FRAMES_PER_SECOND
    speed = clip_speed(scene)
    if speed is None:
        sys.stderr.write(
            f"how fast the clip goes is not known: {FRAMES_PER_SECOND:g} frames a second are assumed "
            f"(--frames-per-second states it): {flags.scene}\n"
        )
    return speed or FRAMES_PER_SECOND


def _write_splats(
    folder: Path, suffix: str, scene: Scene, kept: Scene, wanted: list[Moment], degree: int | None
) -> None:
    """The Gaussians that are `kept` of the scene, where they are at each moment; every file says what it is
    of."""
    unobserved = None if kept is scene else False
    sources, layout, beyond = Opened(model=scene), layout_of(suffix), list[str]()
    with filled(folder) as staging, progress("export", len(wanted)) as report:
        for done, moment in enumerate(wanted, start=1):
            when = {"frame": moment.frame, "time": moment.time}
            record = extended(
                Splats, scene.record, **when, sh_degree=degree, unobserved=unobserved, layout=layout
            )
            file = staging / f"{moment.name}{suffix}"
            run_to_end(make(record, sources, file))
            if suffix.endswith(tuple(CLIPPED)) and not beyond:
                # Of the first that has any: the others are much like it.
                beyond = [f"{notice}: {folder / file.name}" for notice in recorded(file).get("clipped", ())]
            report(done, moment.name)
    sys.stderr.writelines(f"{notice}\n" for notice in beyond)
    say_older(folder, [f"{moment.name}{suffix}" for moment in wanted])
    of_each = "" if scene.split_by_time else f" of {count(len(kept.model), 'Gaussian')}"
    sys.stdout.write(f"{folder}: {count(len(wanted), 'splat file')}{of_each}\n")


def _write_moving(path: Path, scene: Scene, kept: Scene, speed: float) -> None:
    """The Gaussians that are `kept` of the scene, through all of the clip."""
    seconds, unobserved = len(scene.cameras) / speed, None if kept is scene else False
    record = extended(MovingSplats, scene.record, seconds=seconds, unobserved=unobserved)
    with progress("export", len(scene.cameras)) as report:
        for done in make(record, Opened(model=scene), path):
            report(done, path.name)
    said = f"{len(kept.model)} Gaussians at {count(len(scene.cameras), 'moment')}"
    if path.suffix.lower() == fourdgs.SUFFIX and scene.model.raw.harmonics.shape[1]:
        sys.stderr.write(f"colours by direction are left out of the file: {path}\n")
    sys.stdout.write(f"{path}: {said}, {path.stat().st_size / 1e6:.1f} MB\n")


def _write_page(path: Path, scene: Scene, wanted: list[Moment], speed: float, *, beyond: bool) -> None:
    """As the camera of the first moment sees it."""
    record = browser_model(scene, wanted[0].camera, speed, unobserved=beyond)
    run_to_end(make(record, Opened(model=scene), path))
    if scene.model.raw.harmonics.shape[1]:
        sys.stderr.write(f"colours by direction are left out of the page: {path}\n")
    if said := far_off(replace(record, error=recorded(path).get("error")), scene.unit):
        sys.stderr.write(f"the motion is {said}, as the page would be too large: {path}\n")
    sys.stdout.write(f"{path}: {len(scene.model)} Gaussians, {path.stat().st_size / 1e6:.1f} MB\n")


def _write_video(
    path: Path, views: list[ViewRequest], pen: Drawer, wanted: list[Moment], speed: float
) -> None:
    seen = tuple(
        MomentRecord(frame=moment.frame, time=moment.time, camera=moment.camera, near=view.near)
        for moment, view in zip(wanted, views, strict=True)
    )
    said = drawn_record(views[0], pen.name)
    record = extended(RenderVideo, said, frames_per_second=speed, moments=seen)
    with progress("draw", len(wanted)) as report:
        for done in make(record, Opened(tuple(views), pen=pen), path):
            if done:
                report(done, wanted[done - 1].name)
    for notice in recorded(path)["video"]["notices"]:
        sys.stderr.write(f"{notice}: {path}\n")
    sys.stdout.write(f"{path}: {count(len(wanted), 'frame')} rendered with {pen.name}\n")
