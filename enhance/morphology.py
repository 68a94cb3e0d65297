"""Morphological opening by a disc: what is narrower and brighter than its surroundings goes."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.image import Float32Image

STRIP: Final = 64
"""Rows of one task."""
TILE: Final = 256
"""Columns that are worked on at once: so many in as many rows as a disc has stay in the first-level cache."""
MOST_STEP: Final = 16
MOST = np.float32(np.inf)


def step_of(radius: int) -> int:
    """Pixels, a power of two, along a side of the blocks whose means are opened: a disc of `radius` pixels is
    then 8 to 15 blocks in radius, or less where it is small."""
    return int(min(MOST_STEP, 1 << max(0, (radius // 8).bit_length() - 1)))


def opened(small: Float32Image, radius: int) -> Float32Image:
    """(h, w) opened by a disc of `radius` of its pixels, and smoothed; beyond the border there is nothing."""
    side = 2 * radius + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    reaches = disc[radius:].sum(axis=1, dtype=np.int64) // 2
    eroded, result = np.empty_like(small), np.empty_like(small)
    _erode(small, reaches, np.float32(1), eroded)
    _erode(eroded, reaches, np.float32(-1), result)
    return np.asarray(cv2.GaussianBlur(result, (0, 0), 0.6))


@njit(parallel=True, nogil=True, cache=True, error_model="numpy")
def _erode(
    plane: NDArray[np.float32],  # (h, w)
    reaches: NDArray[np.int64],  # (radius + 1,): columns on either side, so many rows from the middle
    sign: np.float32,  # 1: the smallest value under the disc; -1: the largest
    out: NDArray[np.float32],  # (h, w), out
) -> None:
    """Each row counts in those up to the disc's radius away, by its minima over the columns they need."""
    rows, columns = plane.shape
    radius = len(reaches) - 1
    for strip in prange((rows + STRIP - 1) // STRIP):
        top, bottom = strip * STRIP, min((strip + 1) * STRIP, rows)
        least = np.empty((bottom - top, TILE), np.float32)
        row = np.empty(TILE + 2 * radius, np.float32)
        narrow = np.empty(TILE, np.float32)
        for x0 in range(0, columns, TILE):
            least[:] = MOST
            row[:] = MOST
            start, end = max(x0 - radius, 0), min(x0 + TILE + radius, columns)
            count = min(TILE, columns - x0)
            for y in range(max(top - radius, 0), min(bottom + radius, rows)):
                _read(plane[y, start:end], sign, row[start - x0 + radius :])
                _count(row, y - top, reaches, narrow, least)
            for y in range(top, bottom):
                _read(least[y - top, :count], sign, out[y, x0 : x0 + count])


@njit(error_model="numpy")
def _read(line: NDArray[np.float32], sign: np.float32, out: NDArray[np.float32]) -> None:
    for x in range(len(line)):
        out[x] = sign * line[x]


@njit(error_model="numpy")
def _count(
    row: NDArray[np.float32],
    at: int,
    reaches: NDArray[np.int64],
    narrow: NDArray[np.float32],
    least: NDArray[np.float32],
) -> None:
    """Take a row into account; the disc is widest at its middle, so minima only widen towards it."""
    radius = len(reaches) - 1
    narrow[:] = row[radius : radius + TILE]
    done = 0
    for away in range(radius, -1, -1):
        while done < reaches[away]:
            done += 1
            _widen(row[radius - done :], row[radius + done :], narrow)
        if 0 <= at - away < len(least):
            _lower(narrow, least[at - away])
        if 0 <= at + away < len(least) and away > 0:
            _lower(narrow, least[at + away])


@njit(error_model="numpy")
def _widen(left: NDArray[np.float32], right: NDArray[np.float32], narrow: NDArray[np.float32]) -> None:
    for i in range(TILE):
        outer = left[i] if left[i] < right[i] else right[i]
        narrow[i] = outer if outer < narrow[i] else narrow[i]


@njit(error_model="numpy")
def _lower(narrow: NDArray[np.float32], least: NDArray[np.float32]) -> None:
    for i in range(TILE):
        least[i] = narrow[i] if narrow[i] < least[i] else least[i]
