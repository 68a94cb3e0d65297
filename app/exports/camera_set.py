"""Cameras of moments, in the formats of other programs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

from app.files.atomic import filled, write_bytes
from renderer.camera_files import NamedCamera, splatting_json, transforms_json
from renderer.colmap_text import write_colmap
from renderer.gaussians import DynamicGaussians

CameraFormat = Literal["splatting", "transforms", "colmap"]
ENDINGS: Final[Mapping[CameraFormat, str]] = {
    "splatting": ".json",
    "transforms": ".transforms.json",
    "colmap": "",
}
"""Of names; a folder has none."""


@dataclass(frozen=True, eq=False)
class CameraSet:
    """Where moments are seen from."""

    named: tuple[NamedCamera, ...]
    """After the images of them, without suffix."""
    times: tuple[float, ...]
    """In [0, 1] over the clip."""
    model: DynamicGaussians
    """That is seen."""


def write_cameras(target: Path, cameras: CameraSet, form: CameraFormat) -> None:
    """cameras.json of 3D Gaussian Splatting, transforms.json of NeRF, or a folder with COLMAP's text model.

    Raises OSError: it cannot be written.
    """
    images = tuple(NamedCamera(f"{one.name}.png", one.camera) for one in cameras.named)
    if form == "colmap":
        with filled(target) as staging:
            write_colmap(staging, images, cameras.model.at(cameras.times[0]))
    elif form == "transforms":
        write_bytes(target, transforms_json(images, cameras.times))
    else:
        write_bytes(target, splatting_json(cameras.named))


def form_of(ending: str) -> CameraFormat:
    """The format of names that end so."""
    return next(form for form, own in ENDINGS.items() if own == ending)
