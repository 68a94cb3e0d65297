"""Morphological opening by a disc: what is narrower and brighter than its surroundings goes.

Whole numbers of 16 bits stand for floats: twice as many are compared at once, in steps too small to show.
"""

from __future__ import annotations

from typing import Any, Final

import cv2
import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.image import Float32Image
from enhance.part import part
from enhance.pixel_block import HALF, copy_row
from enhance.rows import reflected
from enhance.wide_vectors import wide_vectors

PAIR: Final = 128
"""Rows of two tasks at most: their number is even, for as many threads to end at once."""
TILE: Final = 256
"""Columns that are worked on at once: so many in as many rows as a disc has stay in the first-level cache."""
MOST_STEP: Final = 16
SIDE = np.float32(np.exp(-0.5 / 0.6**2) / (1 + 2 * np.exp(-0.5 / 0.6**2)))
MIDDLE = np.float32(1) - 2 * SIDE
"""A Gaussian of 0.6 pixels."""
Levels = NDArray[np.uint16]
MOST, AS_IS = np.uint16(0xFFFF), np.uint16(0)
"""Exclusive or with MOST turns small into large and large into small, so that minima serve for maxima."""


def step_of(radius: int) -> int:
    """Pixels, a power of two, along a side of the blocks whose means are opened: a disc of `radius` pixels is
    then 8 to 15 blocks in radius, or half as many as pixels where it is small."""
    return int(min(MOST_STEP, 1 << max(1, (radius // 8).bit_length() - 1)))


def opened(small: Float32Image, radius: int) -> Float32Image:
    """(h, w) opened by a disc of `radius` of its pixels, in steps of 1/65535 of its range, and smoothed.

    Beyond the border there is nothing.
    """
    side = 2 * radius + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    reaches = disc[radius:].sum(axis=1, dtype=np.int64) // 2
    low, high, _, _ = cv2.minMaxLoc(small)
    unit = (high - low) / int(MOST) or 1.0
    eroded, levels = np.empty(small.shape, np.uint16), np.empty(small.shape, np.uint16)
    _erode(small, np.float32(low), np.float32(1 / unit), reaches, AS_IS, eroded)
    _erode(eroded, np.float32(0), np.float32(1), reaches, MOST, levels)
    result = np.empty_like(small)
    _smooth(levels, np.float32(low), np.float32(unit), result)
    return result


@njit(parallel=True, nogil=True, cache=True, error_model="numpy")
def _erode(
    plane: NDArray[Any],  # (h, w)
    low: np.float32,  # its level 0
    inverse: np.float32,  # of its step from level to level
    reaches: NDArray[np.int64],  # (radius + 1,): columns on either side, so many rows from the middle
    flip: np.uint16,  # AS_IS: the smallest value under the disc; MOST: the largest
    out: Levels,  # (h, w), out
) -> None:
    """Each row counts in those up to the disc's radius away, by its minima over the columns they need."""
    rows, columns = plane.shape
    radius = len(reaches) - 1
    strips = 2 * ((rows + PAIR - 1) // PAIR)
    for strip in prange(strips):
        top, bottom = rows * strip // strips, rows * (strip + 1) // strips
        least = np.empty((bottom - top, TILE), np.uint16)
        row = np.empty(TILE + 2 * radius, np.uint16)
        narrow = np.empty(TILE, np.uint16)
        for x0 in range(0, columns, TILE):
            least[:] = MOST
            row[:] = MOST
            start, end = max(x0 - radius, 0), min(x0 + TILE + radius, columns)
            count = min(TILE, columns - x0)
            for y in range(max(top - radius, 0), min(bottom + radius, rows)):
                _read(plane[y, start:end], low, inverse, flip, row[start - x0 + radius :])
                _count(row, y - top, reaches, narrow, least)
            for y in range(top, bottom):
                _write(least[y - top], flip, out[y, x0 : x0 + count])


@njit(parallel=True, nogil=True, cache=True, error_model="numpy")
def _smooth(levels: Levels, low: np.float32, unit: np.float32, out: NDArray[np.float32]) -> None:
    """Weighted by SIDE, MIDDLE, SIDE both ways; the border reflects, without the pixel at it."""
    rows, columns = levels.shape
    strips = 2 * ((rows + PAIR - 1) // PAIR)
    for strip in prange(strips):
        line = np.empty(columns + 2, np.float32)
        for y in range(rows * strip // strips, rows * (strip + 1) // strips):
            above, below = reflected(y - 1, rows), reflected(y + 1, rows)
            _weigh(levels[above], levels[y], levels[below], line[1:])
            line[0], line[columns + 1] = (
                line[1 + reflected(-1, columns)],
                line[1 + reflected(columns, columns)],
            )
            _weigh(line, line[1:], line[2:], out[y])
            for x in range(columns):
                out[y, x] = low + unit * out[y, x]


@part()
def _weigh(left: NDArray[Any], middle: NDArray[Any], right: NDArray[Any], out: NDArray[np.float32]) -> None:
    wide_vectors()
    for x in range(min(len(right), len(out))):
        beside = np.float32(left[x]) + np.float32(right[x])
        out[x] = MIDDLE * np.float32(middle[x]) + SIDE * beside


@part()
def _read(line: NDArray[Any], low: np.float32, inverse: np.float32, flip: np.uint16, out: Levels) -> None:
    wide_vectors()
    for x in range(len(line)):
        out[x] = np.uint16(np.int32((np.float32(line[x]) - low) * inverse + HALF)) ^ flip


@part()
def _write(least: Levels, flip: np.uint16, out: Levels) -> None:
    wide_vectors()
    for x in range(len(out)):
        out[x] = least[x] ^ flip


@part()
def _count(
    row: Levels,
    at: int,
    reaches: NDArray[np.int64],
    narrow: Levels,
    least: Levels,
) -> None:
    """Take a row into account; the disc is widest at its middle, so minima only widen towards it."""
    wide_vectors()
    radius = len(reaches) - 1
    copy_row(row[radius:], narrow)
    done = 0
    for away in range(radius, -1, -1):
        while done < reaches[away]:
            done += 1
            _widen(row, np.uint64(radius - done), np.uint64(radius + done), narrow)
        if 0 <= at - away < len(least):
            _lower(narrow, np.uint64(at - away), least)
        if 0 <= at + away < len(least) and away > 0:
            _lower(narrow, np.uint64(at + away), least)


@part(forceinline=True)
def _widen(row: Levels, left: np.uint64, right: np.uint64, narrow: Levels) -> None:
    """Places, not slices, which would be counted as references."""
    wide_vectors()
    for i in range(np.uint64(TILE)):
        outer = row[left + i] if row[left + i] < row[right + i] else row[right + i]
        narrow[i] = outer if outer < narrow[i] else narrow[i]


@part(forceinline=True)
def _lower(narrow: Levels, y: np.uint64, least: Levels) -> None:
    wide_vectors()
    for i in range(np.uint64(TILE)):
        least[y, i] = narrow[i] if narrow[i] < least[y, i] else least[y, i]
