"""`vesselsplat export RUN --cameras FILE|DIR`: where frames are seen from, for other programs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from app.errors import UserError
from app.files.atomic import filled, write_bytes
from app.scenes.scene import Scene
from app.scenes.view_selection import Moment
from renderer.camera_files import NamedCamera, off_center, splatting_json, transforms_json
from renderer.colmap_text import write_colmap

FORMATS: Final = ("splatting", "transforms", "colmap")


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--cameras", type=Path, metavar="FILE|DIR", help="the poses as cameras.json")
    parser.add_argument(
        "--cameras-format",
        choices=FORMATS,
        default="splatting",
        help="cameras.json of 3D Gaussian Splatting, transforms.json of NeRF with times, or a folder with a "
        "text model of COLMAP, its points the Gaussians at the first moment (default splatting); images are "
        "named as `render` names them",
    )


def write(flags: argparse.Namespace, scene: Scene, wanted: Sequence[Moment]) -> None:
    """Raises UserError: a folder is wanted and a file is there, or the other way round."""
    path, form = flags.cameras, flags.cameras_format
    if form == "colmap":
        if path.suffix and not path.is_dir():
            raise UserError(f"--cameras: expected a folder for COLMAP, got {path.name}")
        with filled(path) as staging:
            write_colmap(staging, _of_images(wanted), scene.model.at(wanted[0].time))
    elif form == "transforms":
        write_bytes(path, transforms_json(_of_images(wanted), [moment.time for moment in wanted]))
    else:
        named = [NamedCamera(moment.name, moment.camera) for moment in wanted]
        write_bytes(path, splatting_json(named))
        if notice := off_center(named):
            sys.stderr.write(f"{notice}: {path}\n")
    sys.stdout.write(f"{path}: {len(wanted)} cameras\n")


def _of_images(wanted: Sequence[Moment]) -> list[NamedCamera]:
    return [NamedCamera(f"{moment.name}.png", moment.camera) for moment in wanted]
