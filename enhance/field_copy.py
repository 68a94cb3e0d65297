"""A small copy of the picture, in which its field of view is looked for first."""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from enhance.field_regions import Levels
from enhance.image import BYTES, AnyImage, full_scale
from enhance.prefetch import fetch_line
from enhance.wide_vectors import wide_vectors

ONE = 2048
"""Of what OpenCV weighs pixels with."""


def small_copy(pixels: AnyImage, factor: int) -> tuple[Levels, Levels]:
    """(h, w) or (h, w, 3) in grey levels, each pixel from four of the picture, and `low_of` that."""
    if pixels.dtype == BYTES and pixels.flags.c_contiguous:
        # OpenCV and numpy take longer to be called than this takes.
        small, low = _shrunk(pixels if pixels.ndim == 3 else pixels[..., None], factor)
        return small if pixels.ndim == 3 else small[..., 0], low
    height, width = pixels.shape[:2]
    size = max(1, width // factor), max(1, height // factor)
    levels = _in_levels(np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_LINEAR)))
    return levels, low_of(levels)


@njit(cache=True, error_model="numpy")
def _shrunk(pixels: Levels, factor: int) -> tuple[Levels, Levels]:
    """(h, w, n) of (H, W, n), one channel or three, as OpenCV interpolates; and (h, w) `low_of` that."""
    height, width, channels = pixels.shape
    rows, columns = max(1, height // factor), max(1, width // factor)
    small, values = np.empty((rows, columns, channels), np.uint8), np.empty((rows, columns), np.uint8)
    # The colours of a pixel side by side.
    flat, out = pixels.reshape(height, width * channels), small.reshape(rows, columns * channels)
    if rows * factor == height and columns * factor == width:
        _take_means(flat, factor, out, values)
    else:
        _interpolate(flat, out, values)
    low = np.empty_like(values)
    _take_medians(values, low)
    return small, low


@njit(error_model="numpy")
def _interpolate(pixels: Levels, small: Levels, values: Levels) -> None:
    """Between the four pixels about the middle of each block, in OpenCV's whole numbers; values: V."""
    height, (rows, columns) = pixels.shape[0], values.shape
    channels = small.shape[1] // columns
    near, far, left, right = _places(columns, pixels.shape[1] // channels, channels)
    above, below, upper, lower = _places(rows, height, 1)
    for y in range(rows):
        top, bottom, ahead = pixels[above[y]], pixels[below[y]], min(y + 1, rows - 1)
        high, low = upper[y], lower[y]
        one, other = int(above[ahead]) * pixels.shape[1], int(below[ahead]) * pixels.shape[1]
        if channels == 1:
            for x in range(columns):
                at, to = near[x], far[x]
                _fetch(pixels, one + int(at), other + int(at))
                value = _between(top, bottom, at, to, left[x], right[x], high, low)
                small[y, x] = values[y, x] = value
        else:
            for x in range(columns):
                at, to, first, second = near[x], far[x], left[x], right[x]
                _fetch(pixels, one + int(at), other + int(at))
                red = _between(top, bottom, at, to, first, second, high, low)
                at, to = at + np.uint64(1), to + np.uint64(1)
                green = _between(top, bottom, at, to, first, second, high, low)
                at, to = at + np.uint64(1), to + np.uint64(1)
                blue = _between(top, bottom, at, to, first, second, high, low)
                small[y, 3 * x], small[y, 3 * x + 1], small[y, 3 * x + 2] = red, green, blue
                values[y, x] = max(max(red, green), blue)


@njit(forceinline=True, error_model="numpy")
def _between(
    top: Levels,
    bottom: Levels,
    at: np.uint64,
    to: np.uint64,
    left: np.uint32,
    right: np.uint32,
    upper: np.uint32,
    lower: np.uint32,
) -> np.uint32:
    one = np.uint32(np.uint32(top[at]) * left + np.uint32(top[to]) * right) >> np.uint32(4)
    other = np.uint32(np.uint32(bottom[at]) * left + np.uint32(bottom[to]) * right) >> np.uint32(4)
    high, low = np.uint32(upper * one) >> np.uint32(16), np.uint32(lower * other) >> np.uint32(16)
    return np.uint32(np.uint32(high + low + np.uint32(2)) >> np.uint32(2))


@njit(error_model="numpy")
def _places(
    count: int, size: int, step: int
) -> tuple[NDArray[np.uint64], NDArray[np.uint64], NDArray[np.uint32], NDArray[np.uint32]]:
    """Of each of so many pixels in place of `size`, which lie `step` apart: the two that its middle lies
    between, and their shares, in 2048ths."""
    one, other = np.empty(count, np.uint64), np.empty(count, np.uint64)
    shares, others, scale = np.empty(count, np.uint32), np.empty(count, np.uint32), size / count
    for at in range(count):
        middle = np.float32((at + 0.5) * scale - 0.5)
        first = int(np.floor(middle))
        share = np.float32(middle - np.float32(first))
        one[at], other[at] = step * first, step * min(first + 1, size - 1)
        shares[at] = np.rint((np.float32(1) - share) * np.float32(ONE))
        others[at] = np.rint(share * np.float32(ONE))
    return one, other, shares, others


@njit(error_model="numpy")
def _take_means(pixels: Levels, factor: int, small: Levels, values: Levels) -> None:
    """The same of blocks of whole pixels: the mean of the 2 x 2 pixels in the middle, or the one pixel
    there; values: V."""
    is_grey, width = small.shape == values.shape, pixels.shape[1]
    near, far, step = (factor - 1) // 2, factor // 2, factor if is_grey else 3 * factor
    apart = far - near if is_grey else 3 * (far - near)
    sums = np.empty(width, np.uint16)
    for y in range(values.shape[0]):
        _add_rows(pixels[y * factor + near], pixels[y * factor + far], sums)
        # Asked for a row of blocks ahead: what lies so far apart comes slowly.
        ahead, beyond = ((y + 1) * factor + near) * width, ((y + 1) * factor + far) * width
        if is_grey:
            for x in range(values.shape[1]):
                at = near + x * step
                _fetch(pixels, ahead + at, beyond + at)
                values[y, x] = small[y, x] = _mean(sums, at, apart)
        else:
            for x in range(values.shape[1]):
                at = 3 * near + x * step
                _fetch(pixels, ahead + at, beyond + at)
                red, green, blue = (
                    _mean(sums, at, apart),
                    _mean(sums, at + 1, apart),
                    _mean(sums, at + 2, apart),
                )
                small[y, 3 * x], small[y, 3 * x + 1], small[y, 3 * x + 2] = red, green, blue
                values[y, x] = max(max(red, green), blue)


@njit(error_model="numpy")
def _add_rows(one: Levels, other: Levels, sums: NDArray[np.uint16]) -> None:
    wide_vectors()
    for i in range(len(sums)):
        sums[i] = np.uint16(one[i]) + np.uint16(other[i])


@njit(forceinline=True, error_model="numpy")
def _fetch(pixels: Levels, one: int, other: int) -> None:
    fetch_line(pixels, one)  # type: ignore[call-arg]
    fetch_line(pixels, other)


@njit(forceinline=True, error_model="numpy")
def _mean(sums: NDArray[np.uint16], at: int, apart: int) -> int:
    """Of two rows, two pixels of each."""
    total = np.uint32(sums[np.uint64(at)]) + np.uint32(sums[np.uint64(at + apart)])
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
