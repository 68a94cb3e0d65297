"""`vesselsplat export RUN --cameras FILE|DIR`: where frames are seen from, for other programs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from app.commands.view_selection import Moment
from app.errors import UserError
from app.exports.camera_set import ENDINGS, CameraSet, write_cameras
from app.scenes.scene import Scene
from renderer.camera_files import NamedCamera, off_center
from renderer.listing import count

JSON: Final = ".json"


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--cameras-format",
        choices=ENDINGS,
        default="splatting",
        help="cameras.json of 3D Gaussian Splatting, transforms.json of NeRF with times, or a folder with a "
        "text model of COLMAP, its points the Gaussians at the first moment (default splatting); images are "
        "named as `render` names them",
    )


def check(flags: argparse.Namespace) -> None:
    """Raises UserError: the name is not that of a folder, or file, as the format wants it."""
    path: Path | None = flags.cameras
    if path is None:
        return
    if flags.cameras_format == "colmap":
        if path.suffix and not path.is_dir():
            raise UserError(f"--cameras: expected a folder for COLMAP, got {path.name or path}")
    elif path.suffix.lower() != JSON:
        raise UserError(f"--cameras: expected the name of a {JSON} file, got {path.name or path}")


def write(flags: argparse.Namespace, scene: Scene, wanted: Sequence[Moment]) -> None:
    path, form = flags.cameras, flags.cameras_format
    named = tuple(NamedCamera(moment.name, moment.camera) for moment in wanted)
    times = tuple(moment.time for moment in wanted)
    write_cameras(path, CameraSet(named, times, scene.model), form)
    if form == "splatting" and (notice := off_center(named)):
        sys.stderr.write(f"{notice}: {path}\n")
    sys.stdout.write(f"{path}: {count(len(wanted), 'camera')}\n")
