"""`vesselsplat export RUN --ply DIR | --video FILE | --cameras FILE`: a model for other programs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

from app import moments, scene_view
from app.atomic import filled, together, write_bytes
from app.color_bar import with_bar
from app.drawers import drawn_by
from app.errors import UserError
from app.moments import Moment
from app.pictures import ArrayImage
from app.progress import progress
from app.provenance import comments, repeatable, write_sidecar
from app.scene import Scene
from app.video import Timing, write_video
from renderer.camera_files import NamedCamera, off_center, splatting_json
from renderer.harmonics import BANDS
from renderer.near_plane import near_plane
from renderer.raw_gaussians import RawGaussians
from renderer.splat_files.inria_ply import ply_bytes


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--ply", type=Path, metavar="DIR", help="a splat file a frame, numbered, as viewers play them"
    )
    parser.add_argument(
        "--sh-degree",
        type=int,
        choices=range(len(BANDS)),
        metavar="D",
        help="of the splat files' spherical harmonics, 0 to 3, filled up with zeros (default the model's): "
        "the original viewer of 3D Gaussian Splatting reads degree 3 alone",
    )
    parser.add_argument(
        "--video", type=Path, metavar="FILE", help="the frames as a video, with a JSON beside"
    )
    parser.add_argument("--cameras", type=Path, metavar="FILE", help="the poses as cameras.json")
    moments.add_flags(parser)
    scene_view.add_flag(parser)


def run(flags: argparse.Namespace) -> None:
    if not (flags.ply or flags.video or flags.cameras):
        raise UserError("expected what to export: --ply DIR, --video FILE or --cameras FILE")
    if flags.sh_degree is not None and not flags.ply:
        raise UserError("--sh-degree: expected --ply DIR, whose files it is of")
    scene, wanted = moments.chosen(flags)
    if flags.ply:
        _write_plys(flags.ply, scene, wanted, flags.sh_degree)
    if flags.video:
        _write_video(flags, scene, wanted)
    if flags.cameras:
        named = [NamedCamera(moment.name, moment.camera) for moment in wanted]
        write_bytes(flags.cameras, splatting_json(named))
        if notice := off_center(named):
            sys.stderr.write(f"{notice}: {flags.cameras}\n")
        sys.stdout.write(f"{flags.cameras}: {len(wanted)} cameras\n")


def _write_plys(folder: Path, scene: Scene, wanted: list[Moment], degree: int | None) -> None:
    """The Gaussians where they are at each moment; every file says what it is of."""
    still = _of_degree(scene.model.raw, degree)
    asked = {} if degree is None else {"sh_degree": degree}
    with filled(folder) as staging, progress("export", len(wanted)) as report:
        for done, moment in enumerate(wanted, start=1):
            raw = scene.model.motion.moved(still, moment.time)
            facts = repeatable(kind="splats", **scene.facts, frame=moment.frame, time=moment.time, **asked)
            (staging / f"{moment.name}.ply").write_bytes(ply_bytes(raw, scene.mode, comments(facts)))
            report(done, moment.name)
    sys.stdout.write(f"{folder}: {len(wanted)} splat files of {len(scene.model)} Gaussians\n")


def _of_degree(raw: RawGaussians, degree: int | None) -> RawGaussians:
    """Raises UserError for a degree that would lose colours."""
    try:
        return raw if degree is None else raw.of_degree(degree)
    except ValueError as error:
        raise UserError(
            f"--sh-degree: expected one that holds all of the model, got {degree} for {error}"
        ) from error


def _write_video(flags: argparse.Namespace, scene: Scene, wanted: list[Moment]) -> None:
    draw, by = drawn_by(flags.renderer, flags.supersampling)
    view = scene_view.asked_for(flags, scene, draw).steady(wanted)

    def pictures() -> Iterator[ArrayImage]:
        with progress("draw", len(wanted)) as report:
            for done, moment in enumerate(wanted, start=1):
                yield with_bar(view.at(moment))
                report(done, moment.name)

    seen = [moment.facts | {"near": near_plane(scene.model, moment.camera)} for moment in wanted]
    facts = scene.facts | by | {"background": (0.0, 0.0, 0.0), "view": view.kind, "scale": view.scale}
    with together(flags.video) as place:
        written = write_video(place, pictures(), Timing(flags.frames_per_second))
        facts |= {"frames_per_second": flags.frames_per_second, "moments": seen, "video": written}
        write_sidecar(place, repeatable(kind="render video", **facts))
    sys.stdout.write(f"{flags.video}: {len(wanted)} frames drawn with {by['renderer']}\n")
