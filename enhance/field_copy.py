"""A small copy of the picture, in which its field of view is looked for first."""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit

from enhance.field_regions import Levels
from enhance.image import AnyImage, full_scale


def small_copy(pixels: AnyImage, factor: int) -> tuple[Levels, Levels]:
    """(h, w) or (h, w, 3) in grey levels, each pixel from four of the picture, and V of that."""
    height, width = pixels.shape[:2]
    rows, columns = max(1, height // factor), max(1, width // factor)
    if (rows * factor, columns * factor) != (height, width) or not _is_plain(pixels):
        levels = _in_levels(np.asarray(cv2.resize(pixels, (columns, rows), interpolation=cv2.INTER_LINEAR)))
        return levels, values_of(levels)
    # OpenCV wakes threads of its own, which may take longer than all of the search.
    small: Levels = np.empty((rows, columns, *pixels.shape[2:]), np.uint8)
    values: Levels = np.empty((rows, columns), np.uint8)
    _shrink(pixels.reshape(height, -1), factor, small.reshape(rows, -1), values)
    return small, values


def _is_plain(pixels: AnyImage) -> bool:
    return bool(pixels.dtype == np.uint8 and pixels.flags.c_contiguous)


@njit(cache=True, error_model="numpy")
def _shrink(pixels: Levels, factor: int, small: Levels, values: Levels) -> None:
    """The mean of the 2 x 2 pixels in the middle of each block, or the one pixel there, as OpenCV has it.

    The colours of a pixel are side by side, in (H, 3 W) and (h, 3 w); values: (h, w).
    """
    is_grey = small.shape == values.shape
    near, far, step = (factor - 1) // 2, factor // 2, factor if is_grey else 3 * factor
    apart = far - near if is_grey else 3 * (far - near)
    for y in range(values.shape[0]):
        above, below = pixels[y * factor + near], pixels[y * factor + far]
        if is_grey:
            for x in range(values.shape[1]):
                values[y, x] = small[y, x] = _mean(above, below, near + x * step, apart)
        else:
            for x in range(values.shape[1]):
                at = 3 * near + x * step
                red, green = _mean(above, below, at, apart), _mean(above, below, at + 1, apart)
                blue = _mean(above, below, at + 2, apart)
                small[y, 3 * x], small[y, 3 * x + 1], small[y, 3 * x + 2] = red, green, blue
                values[y, x] = max(max(red, green), blue)


@njit(forceinline=True, error_model="numpy")
def _mean(above: Levels, below: Levels, at: int, apart: int) -> int:
    left, right = np.uint64(at), np.uint64(at + apart)
    total = np.uint32(above[left]) + above[right] + below[left] + below[right]
    return int((total + np.uint32(2)) >> np.uint32(2))


def values_of(small: Levels) -> Levels:
    """(h, w) V."""
    if small.ndim == 2:
        return small
    red, green, blue = cv2.split(small)
    return np.asarray(cv2.max(cv2.max(red, green), blue))


def _in_levels(values: AnyImage) -> Levels:
    if values.dtype == np.uint8:
        return values
    return np.rint(values * (255.0 / full_scale(values.dtype))).astype(np.uint8)
