"""The phantom seen by two eyes: a rectified pair whose disparity and hidden pixels are known."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

import numpy as np
from PIL import Image

from renderer.camera import Camera, FloatArray
from renderer.clip import ByteImage, Frame
from renderer.phantom import Phantom, PhantomParams

BASELINE = 4.2
"""mm"""


class RightEye(Phantom):
    """The same scene from BASELINE to the right, with a lamp and noise of its own."""

    def camera(self, index: int) -> Camera:
        shift = np.eye(4)
        shift[0, 3] = -BASELINE
        camera = super().camera(index)
        return camera.moved(shift @ camera.camera_from_world)

    def _expose(self, light: FloatArray, index: int) -> ByteImage:
        return super()._expose(light, index + 10_000)


@dataclass(frozen=True, eq=False)
class Eyes:
    """One moment in both eyes, and the truth about it."""

    left: Frame
    right: Frame
    disparity: FloatArray
    """(H, W) px, 0 on tools."""
    seen: np.ndarray
    """(H, W) True = tissue of the left picture that the right one shows too."""
    hidden: np.ndarray
    """(H, W) True = tissue that it does not show: outside its view, or behind a tool or a fold."""


def look(index: int = 0, **params: object) -> Eyes:
    """Read-only: the same moment is seen once for all tests of a process."""
    return _seen(PhantomParams(**params), index)  # type: ignore[arg-type]


def write_eyes(folder: Path, left: str, right: str, count: int = 1, **params: object) -> list[Eyes]:
    """Writes `count` moments; `left` and `right` are paths with a place for the number, {:06d}."""
    moments = [look(index, n_frames=count, **params) for index in range(count)]
    for index, eyes in enumerate(moments):
        for pattern, frame in ((left, eyes.left), (right, eyes.right)):
            path = folder / pattern.format(index)
            path.parent.mkdir(parents=True, exist_ok=True)
            Image.fromarray(frame.image).save(path)
    return moments


@cache
def _scene(params: PhantomParams) -> tuple[Phantom, RightEye]:
    return Phantom(params), RightEye(params)


@lru_cache(maxsize=24)
def _seen(params: PhantomParams, index: int) -> Eyes:
    left, right = (eye.view(index).frame for eye in _scene(params))
    assert left.depth is not None
    assert right.depth is not None
    tissue = left.tissue_mask
    disparity = np.where(tissue, left.camera.fx * BASELINE / np.where(tissue, left.depth, 1), 0)
    there = np.arange(left.camera.width) + 0.5 - disparity
    columns = np.clip(np.floor(there).astype(int), 0, left.camera.width - 1)
    same = np.abs(np.take_along_axis(right.depth, columns, axis=1) - left.depth) < 1
    seen = tissue & (there >= 0) & same
    eyes = Eyes(left, right, disparity, seen, tissue & ~seen)
    for array in (left.image, left.depth, right.image, right.depth, disparity, seen, eyes.hidden):
        array.flags.writeable = False
    return eyes
