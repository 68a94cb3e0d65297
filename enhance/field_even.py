"""A surround of one colour that is not black: a page, a slide, or the window of another program."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from enhance.brightness import BLACK
from enhance.field import FieldOfView, beyond
from enhance.field_regions import Levels
from enhance.field_shape import around_circle
from enhance.field_tones import ranked
from enhance.image import AnyImage, full_scale

EVEN: Final = 6
"""Grey levels from the surround's colour that the middle tone of a corner lies within: lamps of scanners and
lenses of cameras leave that."""
NOISE: Final = 12
"""Grey levels that three quarters of a corner lie within."""
ALIKE: Final = 3
"""Corners at least, of four: there may be text in one."""
CORNER: Final = 24
"""Times a corner's side in the shorter one of the small copy."""
LEAST_BOX: Final = 0.95
"""Of the rectangle around it, that a field covers which is one."""


@njit(error_model="numpy")
def corners_of(colors: Levels) -> tuple[NDArray[np.int16], int]:
    """The colour of squares in the corners of a small copy, (h, w, n), the mean of the two middle ones of
    their tones, and how many have it, none of them black."""
    height, width, channels = colors.shape
    if colors.size == 0 or not _may_be_even(colors):
        return np.empty(0, np.int16), 0
    side = max(2, min(height, width) // CORNER)
    size, color = side * side, np.empty(channels, np.int16)
    tones, alike = np.empty(4, np.int16), np.ones(4, np.bool_)
    for channel in range(channels):
        for corner in range(4):
            counts = np.zeros(256, np.int16)
            top, left = (height - side) * (corner % 2), (width - side) * (corner // 2)
            for y in range(top, top + side):
                for x in range(left, left + side):
                    counts[colors[y, x, channel]] += 1
            tones[corner] = ranked(counts, size // 2)
            alike[corner] &= ranked(counts, size - 1 - size // 8) - ranked(counts, size // 8) <= NOISE
        color[channel] = (tones.sum() - tones.min() - tones.max()) // 2
        for corner in range(4):
            alike[corner] &= abs(tones[corner] - color[channel]) <= EVEN
    return color, alike.sum()


@njit(error_model="numpy")
def _may_be_even(colors: Levels) -> bool:
    """Of values of which three are alike, the two in the middle are: nearly every image is told by those of
    the corner pixels."""
    brightest = 0
    for channel in range(colors.shape[2]):
        a, b = colors[0, 0, channel], colors[0, -1, channel]
        c, d = colors[-1, 0, channel], colors[-1, -1, channel]
        one, other = max(min(a, b), min(c, d)), min(max(a, b), max(c, d))
        low, high = min(one, other), max(one, other)
        if high - low > NOISE:
            return False
        brightest = max(brightest, high)
    return brightest >= 255 * BLACK


def apart_from(pixels: AnyImage, color: NDArray[np.int16]) -> NDArray[Any]:
    """How far each channel is from a colour in grey levels: black where it is that. uint8 of uint8, else
    float32 in [0, 1]; shaped as the pixels."""
    target: NDArray[Any] = color if pixels.ndim == 3 else color[0]
    if pixels.dtype == np.uint8:
        return np.asarray(np.abs(pixels - target).astype(np.uint8))
    scale = np.float32(1 / full_scale(pixels.dtype))
    return np.asarray(np.abs(pixels.astype(np.float32) * scale - target.astype(np.float32) / 255))


def box_of(field: FieldOfView) -> tuple[int, int, int, int]:
    """First column and row of the picture that a field reaches into, and the ones after its last."""
    ends = list[tuple[float, float]]()
    for one in field.parts or (field,):
        if one.circle is not None:
            x, y, radius = one.circle
            ends += [(x - radius, y - radius), (x + radius, y + radius)]
        else:
            ends += one.polygon or [(0, 0), (field.width, field.height)]
    least, most = np.min(ends, axis=0), np.max(ends, axis=0)
    left, top = np.maximum(np.floor(least), 0).astype(int).tolist()
    right, bottom = np.minimum(np.ceil(most), (field.width, field.height)).astype(int).tolist()
    return left, top, right, bottom


def is_box(part: FieldOfView) -> bool:
    """Whether a part, no circle, is the rectangle around it, as images on a page are."""
    if part.polygon is None:
        return False
    left, top, right, bottom = box_of(part)
    corners = np.clip(np.array(part.polygon), (left, top), (right, bottom)).astype(np.float32)
    return bool(cv2.contourArea(corners) >= LEAST_BOX * (right - left) * (bottom - top))


def moved(part: FieldOfView, box: tuple[int, int, int, int], whole: FieldOfView) -> FieldOfView:
    """A part of an image that fills this box of another one, which is `whole`."""
    left, top, right, bottom = box
    if part.circle is not None:
        x, y, radius = part.circle
        if min(x, y, part.width - x, part.height - y) >= radius:
            return replace(whole, circle=(x + left, y + top, radius))
    corners = around_circle(part.circle) if part.circle is not None else np.array(part.polygon, np.float64)
    corners = corners + np.array([left, top])
    for inward, least in (((1, 0), left), ((0, 1), top), ((-1, 0), -right), ((0, -1), -bottom)):
        corners = beyond(corners, np.array(inward, np.float64), least)
    return replace(whole, polygon=tuple((round(float(x), 1), round(float(y), 1)) for x, y in corners))
