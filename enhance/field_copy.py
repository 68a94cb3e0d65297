"""A small copy of the picture, in which its field of view is looked for first."""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit

from enhance.field_regions import Levels
from enhance.image import BYTES, AnyImage, full_scale
from enhance.prefetch import fetch_line
from enhance.wide_vectors import wide_vectors


def small_copy(pixels: AnyImage, factor: int) -> tuple[Levels, Levels]:
    """(h, w) or (h, w, 3) in grey levels, each pixel from four of the picture, and `low_of` that."""
    height, width = pixels.shape[:2]
    rows, columns = max(1, height // factor), max(1, width // factor)
    if (rows * factor, columns * factor) != (height, width) or not _is_plain(pixels):
        levels = _in_levels(np.asarray(cv2.resize(pixels, (columns, rows), interpolation=cv2.INTER_LINEAR)))
        return levels, low_of(levels)
    # OpenCV wakes threads of its own, which may take longer than all of the search.
    small: Levels = np.empty((rows, columns, *pixels.shape[2:]), np.uint8)
    low: Levels = np.empty((rows, columns), np.uint8)
    _shrink(pixels.reshape(height, -1), factor, small.reshape(rows, -1), low)
    return small, low


def _is_plain(pixels: AnyImage) -> bool:
    return bool(pixels.dtype == BYTES and pixels.flags.c_contiguous)


@njit(cache=True, error_model="numpy")
def _shrink(pixels: Levels, factor: int, small: Levels, low: Levels) -> None:
    """The mean of the 2 x 2 pixels in the middle of each block, or the one pixel there, as OpenCV has it.

    The colours of a pixel are side by side, in (H, 3 W) and (h, 3 w); low: (h, w).
    """
    is_grey, values, width = small.shape == low.shape, np.empty_like(low), pixels.shape[1]
    near, far, step = (factor - 1) // 2, factor // 2, factor if is_grey else 3 * factor
    apart = far - near if is_grey else 3 * (far - near)
    for y in range(values.shape[0]):
        above, below = pixels[y * factor + near], pixels[y * factor + far]
        # Asked for a row of blocks ahead: what lies so far apart comes slowly.
        ahead, beyond = ((y + 1) * factor + near) * width, ((y + 1) * factor + far) * width
        if is_grey:
            for x in range(values.shape[1]):
                at = near + x * step
                _fetch(pixels, ahead + at, beyond + at)
                values[y, x] = small[y, x] = _mean(above, below, at, apart)
        else:
            for x in range(values.shape[1]):
                at = 3 * near + x * step
                _fetch(pixels, ahead + at, beyond + at)
                red, green = _mean(above, below, at, apart), _mean(above, below, at + 1, apart)
                blue = _mean(above, below, at + 2, apart)
                small[y, 3 * x], small[y, 3 * x + 1], small[y, 3 * x + 2] = red, green, blue
                values[y, x] = max(max(red, green), blue)
    _take_medians(values, low)


@njit(forceinline=True, error_model="numpy")
def _fetch(pixels: Levels, one: int, other: int) -> None:
    fetch_line(pixels, one)  # type: ignore[call-arg]
    fetch_line(pixels, other)


@njit(forceinline=True, error_model="numpy")
def _mean(above: Levels, below: Levels, at: int, apart: int) -> int:
    left, right = np.uint64(at), np.uint64(at + apart)
    total = np.uint32(above[left]) + above[right] + below[left] + below[right]
    return int((total + np.uint32(2)) >> np.uint32(2))


@njit(error_model="numpy")
def _take_medians(values: Levels, low: Levels) -> None:
    """Of 3 x 3 pixels: of the least of the columns' largest, the middle of their middles and the largest of
    their least. The border is repeated."""
    wide_vectors()
    height, width = values.shape
    columns = np.empty((3, width + 2), np.uint8)
    for y in range(height):
        above, here, below = values[max(y - 1, 0)], values[y], values[min(y + 1, height - 1)]
        least, middle, most = columns[0, 1:], columns[1, 1:], columns[2, 1:]
        for x in range(width):
            a, b, c = above[x], here[x], below[x]
            least[x], middle[x], most[x] = min(min(a, b), c), _middle(a, b, c), max(max(a, b), c)
        for plane in range(3):
            columns[plane, 0], columns[plane, width + 1] = columns[plane, 1], columns[plane, width]
        least, middle, most = columns[0], columns[1], columns[2]
        row = low[y]
        for x in range(width):
            i, j = np.uint64(x + 1), np.uint64(x + 2)
            highest, lowest = max(max(least[x], least[i]), least[j]), min(min(most[x], most[i]), most[j])
            row[x] = _middle(highest, _middle(middle[x], middle[i], middle[j]), lowest)


@njit(forceinline=True, error_model="numpy")
def _middle(one: np.uint8, other: np.uint8, third: np.uint8) -> np.uint8:
    return max(min(one, other), min(max(one, other), third))


def low_of(small: Levels) -> Levels:
    """(h, w) V without specks: the medians of 3 x 3 pixels."""
    values: AnyImage = small
    if small.ndim == 3:
        red, green, blue = cv2.split(small)
        values = cv2.max(cv2.max(red, green), blue)
    return np.asarray(cv2.medianBlur(values, 3), np.uint8)


def _in_levels(values: AnyImage) -> Levels:
    if values.dtype == np.uint8:
        return values
    return np.rint(values * (255.0 / full_scale(values.dtype))).astype(np.uint8)
