"""The first pass over an image: what the filters and the statistics need of it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.chroma import sample_rows
from enhance.part import part
from enhance.pixel_block import (
    BINS,
    BLOCK,
    CHUNK,
    KEEP,
    LEAST,
    LEAST_COLOR,
    LEVELS,
    MOST,
    ONE,
    QUARTER,
    STEP,
    TOTAL,
    VALUE,
    ZERO,
    keep_within,
    load,
    load_keep,
    zero_chunk,
    zero_row,
)
from enhance.powers import rounded
from enhance.prefetch import fetch
from enhance.wide_vectors import wide_vectors


@njit(parallel=True, nogil=True, cache=True, fastmath={"contract"}, error_model="numpy")
def first_pass(
    image: NDArray[Any],  # (H, W, 3)
    keep: NDArray[np.uint8],  # (H, W) 0 or 1, or empty: all
    spans: NDArray[np.int32],  # (H, 2) of `FieldOfView.spans`, or empty: all
    full: np.float32,  # the image's value of 1.0
    subsample: int,
    fine: NDArray[np.float32],  # (2, h, w), out: of V in each block, the mean and the variance about it
    coarse: NDArray[np.float32],  # (2, h / 2, w / 2) rounded up, out: the same of 2 x 2 blocks; or empty
    histograms: NDArray[np.int64],  # (blocks, BINS), out: of V in grey levels, over the kept pixels
    chroma: NDArray[np.float64],  # (blocks,), out: sum of S over the kept pixels
    step: int,
    samples: NDArray[np.float64],  # (3, n, m), out: of `sample_rows`, `step` pixels apart; or empty
    histogram: NDArray[np.int64],  # (BINS,), out: `histograms` together
) -> None:
    """First pass: V at low resolution, its histogram and the sum of S, and samples of colour and its noise.

    An odd edge repeats what is last.
    """
    held = (fine.shape[2] * subsample + CHUNK + STEP - 1) // STEP * STEP
    for block in prange(len(chroma)):
        _survey_block(
            block,
            image,
            keep,
            spans,
            full,
            subsample,
            fine,
            coarse,
            histograms,
            chroma,
            step,
            samples,
            zero_chunk(),  # type: ignore[call-arg]
            zero_row(5 * CHUNK, image.dtype).reshape((5, CHUNK)),  # type: ignore[call-arg]
            zero_row(3 * held, np.float32).reshape((3, held)),  # type: ignore[call-arg]
            np.empty(CHUNK, np.uint16),
            np.zeros((4, BINS + 1), np.int32),
            zero_row(CHUNK, np.float64),  # type: ignore[call-arg]
        )
    _together(histograms, histogram)


@part(forceinline=True, fastmath={"contract"})
def _survey_block(
    block: int,
    image: NDArray[Any],
    keep: NDArray[np.uint8],
    spans: NDArray[np.int32],
    full: np.float32,
    subsample: int,
    fine: NDArray[np.float32],
    coarse: NDArray[np.float32],
    histograms: NDArray[np.int64],
    chroma: NDArray[np.float64],
    step: int,
    samples: NDArray[np.float64],
    chunk: NDArray[np.float32],
    apart: NDArray[Any],
    lines: NDArray[np.float32],
    levels: NDArray[np.uint16],
    counts: NDArray[np.int32],
    totals: NDArray[np.float64],
) -> None:
    """A task's rows; after `samples` comes memory to work in."""
    rows, columns = image.shape[0], image.shape[1]
    wide_vectors()
    low_rows, width = fine.shape[1], fine.shape[2] * subsample
    unit = ONE / full
    for low_row in range(block * BLOCK, min((block + 1) * BLOCK, low_rows)):
        chunk[TOTAL] = ZERO
        for y in range(low_row * subsample, (low_row + 1) * subsample):
            first, end = (spans[y, 0], spans[y, 1]) if y < len(spans) else (0, columns if y < rows else 0)
            for run in range((columns + CHUNK - 1) // CHUNK):
                x0 = run * CHUNK
                count = min(CHUNK, columns - x0)
                load(image[min(y, rows - 1), x0 : x0 + count], apart, chunk)
                fetch(image, y, x0 + CHUNK)
                _gather(chunk, y == low_row * subsample, x0, lines)
                if first < x0 + count and x0 < end:
                    for i in range(CHUNK):
                        chunk[VALUE, i] = chunk[MOST, i] * unit
                    load_keep(keep, y, x0, count, chunk)
                    if first > x0 or end < x0 + count:
                        keep_within(first, end, x0, chunk)
                    _tally(chunk, levels, counts, count)
        for x in range(columns, width):
            for plane in range(3):
                lines[plane, x] = lines[plane, columns - 1]
        _shrink(lines, subsample, unit, fine[0, low_row], fine[1, low_row])
        totals += chunk[TOTAL]
    # While its rows are in the cache.
    task = BLOCK * subsample
    sample_rows(image, keep, spans, block * task, min((block + 1) * task, rows), step, samples)
    finish(block, fine, coarse, counts, histograms)
    chroma[block] = totals.sum()


@part(forceinline=True, fastmath={"contract"})
def _gather(chunk: NDArray[np.float32], begins: bool, x0: int, lines: NDArray[np.float32]) -> None:
    """Of each column of a block: its first V, and the sum and the squares of what the others differ by.

    Differences to a value that occurs keep a small variance exact to float32.
    """
    wide_vectors()
    first, drift, spread = lines[0, x0 : x0 + CHUNK], lines[1, x0 : x0 + CHUNK], lines[2, x0 : x0 + CHUNK]
    if begins:
        for i in range(CHUNK):
            first[i] = chunk[MOST, i]
        drift[:] = ZERO
        spread[:] = ZERO
    else:
        for i in range(CHUNK):
            apart = chunk[MOST, i] - first[i]
            drift[i] += apart
            spread[i] += apart * apart


@part(forceinline=True, fastmath={"contract"})
def _tally(
    chunk: NDArray[np.float32], levels: NDArray[np.uint16], counts: NDArray[np.int32], count: int
) -> None:
    """Add the chunk's S and V to the sums; four histograms in turn, as equal neighbours would wait."""
    wide_vectors()
    for i in range(CHUNK):
        most = chunk[MOST, i]
        chroma = (most - chunk[LEAST_COLOR, i]) / (most if most > LEAST else LEAST)
        chunk[TOTAL, i] += chunk[KEEP, i] * chroma
        level: np.float32 = rounded(chunk[VALUE, i] * LEVELS)  # type: ignore[call-arg]
        levels[i] = np.int32(level if chunk[KEEP, i] > ZERO else LEVELS + ONE)
    for i in range(count):
        counts[i & 3, levels[i]] += np.int32(1)


@part(fastmath={"contract"})
def _shrink(
    lines: NDArray[np.float32],
    subsample: int,
    unit: np.float32,
    mean: NDArray[np.float32],
    variance: NDArray[np.float32],
) -> None:
    """A row of blocks from their columns."""
    if subsample == 1:
        for x in range(len(mean)):
            mean[x], variance[x] = lines[0, x] * unit, ZERO
    elif subsample == 2:
        _shrink_by(lines, 2, unit, mean, variance)
    elif subsample == 4:
        _shrink_by(lines, 4, unit, mean, variance)
    elif subsample == 8:
        _shrink_by(lines, 8, unit, mean, variance)
    else:
        _shrink_by(lines, subsample, unit, mean, variance)


@part(forceinline=True, fastmath={"contract"})
def _shrink_by(
    lines: NDArray[np.float32],
    subsample: int,
    unit: np.float32,
    mean: NDArray[np.float32],
    variance: NDArray[np.float32],
) -> None:
    """Variances of the columns, and of their means about the block's (Chan, Golub and LeVeque, 1979)."""
    wide_vectors()
    share = ONE / np.float32(subsample)
    first, drifts, spreads = lines[0], lines[1], lines[2]
    for x in range(len(mean)):
        value = first[np.uint64(x * subsample)]
        middle, within, between = ZERO, ZERO, ZERO
        for k in range(subsample):
            i = np.uint64(x * subsample + k)
            middle += (first[i] - value + drifts[i] * share) * share
        for k in range(subsample):
            i = np.uint64(x * subsample + k)
            drift = drifts[i] * share
            within += spreads[i] * share - drift * drift
            apart = first[i] - value + drift - middle
            between += apart * apart
        spread = (within + between) * share * unit * unit
        mean[x] = (value + middle) * unit
        variance[x] = spread if spread > ZERO else ZERO


@part(fastmath={"contract"})
def finish(
    block: int,
    fine: NDArray[np.float32],
    coarse: NDArray[np.float32],
    counts: NDArray[np.int32],  # (4, more than BINS), the histograms in turn
    histograms: NDArray[np.int64],
) -> None:
    """Of a task's BLOCK rows of the fine grid, those of the coarse one; and its histograms together."""
    wide_vectors()
    low_rows = fine.shape[1]
    last = min((block + 1) * BLOCK, low_rows)
    for low_row in range(block * BLOCK // 2, min((last + 1) // 2, coarse.shape[1])):
        _pool(fine, 2 * low_row, min(2 * low_row + 1, low_rows - 1), coarse[:, low_row])
    add_up(block, counts, histograms)


@part(fastmath={"contract"})
def add_up(
    task: int,
    counts: NDArray[np.int32],  # (4, more than BINS), the histograms in turn
    histograms: NDArray[np.int64],  # (tasks, BINS), out
) -> None:
    """A task's histograms together."""
    for level in range(BINS):
        histograms[task, level] = counts[0, level] + counts[1, level] + counts[2, level] + counts[3, level]


@part()
def _together(histograms: NDArray[np.int64], histogram: NDArray[np.int64]) -> None:
    """Of all tasks."""
    wide_vectors()
    for level in range(BINS):
        histogram[level] = 0
    for task in range(len(histograms)):
        for level in range(BINS):
            histogram[level] += histograms[task, level]


@part(fastmath={"contract"})
def _pool(fine: NDArray[np.float32], first: int, second: int, coarse: NDArray[np.float32]) -> None:
    """A row of the coarse grid from two of the fine one."""
    wide_vectors()
    last = fine.shape[2] - 1
    above, below = fine[:, first], fine[:, second]
    for x in range(coarse.shape[1]):
        left, right = 2 * x, min(2 * x + 1, last)
        mean = (above[0, left] + above[0, right] + below[0, left] + below[0, right]) * QUARTER
        within = (above[1, left] + above[1, right] + below[1, left] + below[1, right]) * QUARTER
        a, b = above[0, left] - mean, above[0, right] - mean
        c, d = below[0, left] - mean, below[0, right] - mean
        coarse[0, x], coarse[1, x] = mean, within + (a * a + b * b + c * c + d * d) * QUARTER
