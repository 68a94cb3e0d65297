"""Cameras as a text model of COLMAP: cameras.txt, images.txt and points3D.txt in a folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from renderer.camera import Camera
from renderer.camera_files import NamedCamera
from renderer.rotations import quaternion
from renderer.splats import Splats

UNKNOWN = -1
"""In place of a reprojection error."""


def write_colmap(folder: Path, cameras: Sequence[NamedCamera], splats: Splats) -> None:
    """Into a folder that is there. Lenses that are the same are one camera; points are the centres of the
    `splats`, which no image has measured, so that their tracks are empty.

    Raises OSError: it cannot be written.
    """
    lenses = list(dict.fromkeys(_lens(one.camera) for one in cameras))
    (folder / "cameras.txt").write_text(
        "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n"
        + "".join(f"{number} {lens}\n" for number, lens in enumerate(lenses, start=1)),
        encoding="utf-8",
        newline="\n",
    )
    (folder / "images.txt").write_text(
        "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of POINTS2D[], here empty\n"
        + "".join(
            f"{number} {_pose(one.camera)} {lenses.index(_lens(one.camera)) + 1} {one.name}\n\n"
            for number, one in enumerate(cameras, start=1)
        ),
        encoding="utf-8",
        newline="\n",
    )
    colors = np.rint(splats.colors.clip(0, 1) * 255).astype(int)
    with (folder / "points3D.txt").open("w", encoding="utf-8", newline="\n") as file:
        file.write("# POINT3D_ID X Y Z R G B ERROR TRACK[]\n")
        for number, (place, color) in enumerate(zip(splats.means, colors, strict=True), start=1):
            file.write(f"{number} {' '.join(f'{value:.9g}' for value in place)} ")
            file.write(f"{' '.join(map(str, color))} {UNKNOWN}\n")


def _lens(camera: Camera) -> str:
    numbers = " ".join(repr(float(value)) for value in camera.lens)
    return f"PINHOLE {camera.width} {camera.height} {numbers}"


def _pose(camera: Camera) -> str:
    matrix = camera.camera_from_world
    values = (*quaternion(matrix[:3, :3]), *matrix[:3, 3])
    return " ".join(repr(float(value)) for value in values)
