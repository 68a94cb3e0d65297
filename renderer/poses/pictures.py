"""Frames as the search for poses takes them: grey, of even light, with what may be tracked and its depth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera, FloatArray
from renderer.clip import BoolImage, ByteImage, Frame

WIDEST: Final = 640
"""px: wider pictures are made smaller. Features are found to a tenth of a pixel there."""
_DARK, _BRIGHT = 25, 245
"""Grey levels of a black surround, and of highlights, which follow the lamp."""
_BORDER = 9
"""px, of the surround, tools and highlights that features keep away from."""
_JUMP = 0.1
"""Of the inverse depth, around a feature: more is an edge, where a place in space is not certain."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A frame made small."""

    index: int
    grey: ByteImage
    """(h, w), of even brightness and contrast."""
    usable: BoolImage
    """(h, w), True on lit tissue away from its border."""
    inverse_depth: NDArray[np.float32]
    """(h, w), in units of one over `unit`; 0 = not known, or at an edge."""


def small_lens(camera: Camera) -> Camera:
    """Of the pictures, at the identity."""
    shrink = max(1.0, camera.width / WIDEST)
    size = max(1, round(camera.width / shrink)), max(1, round(camera.height / shrink))
    return camera.resized(*size).moved(np.eye(4))


def picture_of(frame: Frame, lens: Camera, unit: float) -> Picture:
    """The frame at the lens's size; depth in `unit`."""
    size = (lens.width, lens.height)
    return Picture(frame.index, *trackable(frame, size), _inverse(frame, size, unit))


def trackable(frame: Frame, size: tuple[int, int]) -> tuple[ByteImage, BoolImage]:
    """The frame at `size` (width, height), grey and of even brightness and contrast, and what of it is lit
    tissue away from its border: (h, w) each."""
    image = cv2.resize(frame.image, size, interpolation=cv2.INTER_AREA)
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    mask = cv2.resize(frame.tissue_mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)
    lit = ((mask > 0) & (grey > _DARK) & (grey < _BRIGHT)).astype(np.uint8)
    usable = cv2.erode(lit, np.ones((_BORDER, _BORDER), np.uint8)) > 0
    return _evened(grey, size[0] / 32), np.asarray(usable)


def _evened(grey: NDArray[Any], reach: float) -> ByteImage:
    """Local mean and deviation taken out: the lamp moves with the camera, its light is no texture."""
    level = grey.astype(np.float32)
    mean = cv2.GaussianBlur(level, (0, 0), reach)
    spread = np.sqrt(cv2.GaussianBlur((level - mean) ** 2, (0, 0), reach)) + 4
    return np.asarray(np.clip(128 + 40 * (level - mean) / spread, 0, 255), dtype=np.uint8)


def _inverse(frame: Frame, size: tuple[int, int], unit: float) -> NDArray[np.float32]:
    if frame.depth is None:
        return np.zeros(size[::-1], np.float32)
    known = frame.depth_mask & np.isfinite(frame.depth)
    inverse = np.where(known, unit / np.where(known, frame.depth, 1), 0).astype(np.float32)
    share = cv2.resize(known.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    small = cv2.resize(inverse, size, interpolation=cv2.INTER_AREA)
    whole = share > 0.999
    small = np.where(whole, small, 0).astype(np.float32)
    window = np.ones((5, 5), np.uint8)
    low, high = cv2.erode(small, window), cv2.dilate(small, window)
    return np.where((low > 0) & (high - low < _JUMP * high), small, 0).astype(np.float32)


def sampled_inverse(picture: Picture, places: FloatArray) -> FloatArray:
    """(N,) inverse depth at (N, 2) column and row in px of which pixel centres are at +0.5; 0 = not known."""
    if not len(places):
        return np.zeros(0)
    x, y = (places - 0.5).astype(np.float32).T
    around = cv2.remap(picture.inverse_depth, x[:, None], y[:, None], cv2.INTER_LINEAR, borderValue=(0.0,))
    known = cv2.remap(
        (picture.inverse_depth > 0).astype(np.float32),
        x[:, None],
        y[:, None],
        cv2.INTER_LINEAR,
        borderValue=(0.0,),
    )
    return np.where(known[:, 0] > 0.999, around[:, 0], 0).astype(np.float64)


def at_usable(picture: Picture, places: FloatArray) -> BoolImage:
    """Whether (N, 2) px lie on usable tissue; not outside the picture."""
    height, width = picture.usable.shape
    x, y = np.floor(np.clip(places, -1, max(height, width))).astype(np.int64).T
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    return np.asarray(inside & picture.usable[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)])
