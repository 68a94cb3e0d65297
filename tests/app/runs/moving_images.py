"""A folder of images alone, as is left of a clip whose camera moves."""

from __future__ import annotations

import shutil
from pathlib import Path

from renderer.phantom import PhantomParams, write_phantom


def moving_images(folder: Path, params: PhantomParams) -> Path:
    """The images of a phantom, without its depth, poses and masks; `folder` is there."""
    write_phantom(folder / "clip", params)
    shutil.copytree(folder / "clip" / "images", folder / "images")
    return folder / "images"
