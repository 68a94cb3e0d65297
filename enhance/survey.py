"""The first pass over an image: what the filters and the statistics need of it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.chunk import (
    BINS,
    BLOCK,
    CHUNK,
    KEEP,
    LEAST,
    LEAST_COLOR,
    LEVELS,
    MOST,
    ONE,
    PLANES,
    TOTAL,
    VALUE,
    ZERO,
    load,
    load_keep,
)
from enhance.powers import rounded


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def survey(
    image: NDArray[Any],  # (H, W, 3)
    keep: NDArray[np.uint8],  # (H, W) 0 or 1, or empty: all
    full: np.float32,  # the image's value of 1.0
    subsample: int,
    low: NDArray[np.float32],  # (h, w), out: block means of V
    histograms: NDArray[np.int64],  # (blocks, BINS), out: of V in grey levels, over the kept pixels
    chroma: NDArray[np.float64],  # (blocks,), out: sum of S over the kept pixels
) -> None:
    """First pass: V at low resolution, its histogram and the sum of S."""
    rows, columns = image.shape[0], image.shape[1]
    width = low.shape[1] * subsample
    unit = ONE / full
    for block in prange(len(chroma)):
        chunk = np.empty((PLANES, CHUNK), np.float32)
        apart = np.zeros((5, CHUNK), image.dtype)
        line = np.empty(width + CHUNK, np.float32)
        levels = np.empty(CHUNK, np.uint8)
        counts = np.zeros((4, BINS), np.int32)
        total = 0.0
        for low_row in range(block * BLOCK, min((block + 1) * BLOCK, low.shape[0])):
            line[:] = ZERO
            chunk[TOTAL] = ZERO
            for y in range(low_row * subsample, (low_row + 1) * subsample):
                inside = y < rows
                for step in range((columns + CHUNK - 1) // CHUNK):
                    x0 = step * CHUNK
                    count = min(CHUNK, columns - x0)
                    load(image[min(y, rows - 1), x0 : x0 + count], apart, chunk)
                    for i in range(CHUNK):
                        chunk[VALUE, i] = chunk[MOST, i] * unit
                    for i in range(CHUNK):
                        line[x0 + i] += chunk[VALUE, i]
                    if inside:
                        load_keep(keep, y, x0, count, chunk)
                        _tally(chunk, levels, counts, count)
            for x in range(columns, width):
                line[x] = line[columns - 1]
            _shrink(line, subsample, low[low_row])
            for i in range(CHUNK):
                total += np.float64(chunk[TOTAL, i])
        chroma[block] = total
        for level in range(BINS):
            histograms[block, level] = (
                counts[0, level] + counts[1, level] + counts[2, level] + counts[3, level]
            )


@njit(inline="always")
def _tally(
    chunk: NDArray[np.float32], levels: NDArray[np.uint8], counts: NDArray[np.int32], count: int
) -> None:
    """Add the chunk's S and V to the sums; four histograms in turn, as equal neighbours would wait."""
    for i in range(CHUNK):
        most = chunk[MOST, i]
        chroma = (most - chunk[LEAST_COLOR, i]) / (most if most > LEAST else LEAST)
        chunk[TOTAL, i] += chunk[KEEP, i] * chroma
        levels[i] = np.uint8(np.int32(rounded(chunk[VALUE, i] * LEVELS)))  # type: ignore[call-arg]
    for i in range(count):
        counts[i & 3, levels[i]] += np.int32(chunk[KEEP, i])


@njit(inline="always")
def _shrink(line: NDArray[np.float32], subsample: int, out: NDArray[np.float32]) -> None:
    """Block means of a row, which is the sum of the block's rows."""
    if subsample == 1:
        for x in range(len(out)):
            out[x] = line[x]
    elif subsample == 2:
        _shrink_by(line, 2, out)
    elif subsample == 4:
        _shrink_by(line, 4, out)
    elif subsample == 8:
        _shrink_by(line, 8, out)
    else:
        _shrink_by(line, subsample, out)


@njit(inline="always")
def _shrink_by(line: NDArray[np.float32], subsample: int, out: NDArray[np.float32]) -> None:
    mean = ONE / np.float32(subsample * subsample)
    for x in range(len(out)):
        total = ZERO
        for k in range(subsample):
            total += line[x * subsample + k]
        out[x] = total * mean


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def extremes(
    image: NDArray[Any],  # (H, W, 3)
    full: np.float32,  # the image's value of 1.0
    subsample: int,
    darkest: NDArray[np.float32],  # (h, w), out: smallest V of each block
    brightest: NDArray[np.float32],  # (h, w), out: largest V of each block
) -> None:
    """The range of V within each block of the low resolution."""
    rows, columns = image.shape[0], image.shape[1]
    for low_row in prange(darkest.shape[0]):
        chunk = np.empty((PLANES, CHUNK), np.float32)
        apart = np.zeros((5, CHUNK), image.dtype)
        least, most = np.full(columns + CHUNK, full), np.zeros(columns + CHUNK, np.float32)
        for y in range(low_row * subsample, min((low_row + 1) * subsample, rows)):
            for step in range((columns + CHUNK - 1) // CHUNK):
                x0 = step * CHUNK
                count = min(CHUNK, columns - x0)
                load(image[y, x0 : x0 + count], apart, chunk)
                for i in range(CHUNK):
                    least[x0 + i] = min(least[x0 + i], chunk[MOST, i])
                    most[x0 + i] = max(most[x0 + i], chunk[MOST, i])
        for x in range(darkest.shape[1]):
            low, high = full, ZERO
            for column in range(x * subsample, min((x + 1) * subsample, columns)):
                low, high = min(low, least[column]), max(high, most[column])
            darkest[low_row, x], brightest[low_row, x] = low / full, high / full
