"""The first pass of the preset `vessel`: noise of colour goes, and what the statistics and the search for
blood need is gathered.

Sums are never reordered, so results repeat bit for bit.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.calm_color import calm
from enhance.first_pass import add_up
from enhance.part import part
from enhance.pixel_block import (
    BINS,
    BLOCK,
    CHUNK,
    GREEN,
    KEEP,
    LEAST,
    LEAST_COLOR,
    LEVELS,
    ONE,
    QUARTER,
    RED,
    TOTAL,
    VALUE,
    ZERO,
    keep_within,
    load_keep,
    zero_chunk,
)
from enhance.powers import LN_2, brief_log2, rounded
from enhance.prefetch import fetch
from enhance.rows import (
    REACH,
    ROWS,
    SOFT,
    held_width,
    read_row,
)
from enhance.wide_vectors import wide_vectors

SUBSAMPLE: Final = 2
"""Pixels along a side of the blocks in which blood is looked for."""
TASK: Final = SUBSAMPLE * BLOCK
"""Rows of one task."""
FLOOR = np.float32(8 / 255)
"""Added before a logarithm, so that noise in the dark is no structure."""
NEXT = np.uint64(1)


@njit(parallel=True, nogil=True, cache=True, fastmath={"contract"}, error_model="numpy")
def first_pass(
    image: NDArray[Any],  # (H, W, 3)
    keep: NDArray[np.uint8],  # (H, W) 0 or 1, or empty: all
    spans: NDArray[np.int32],  # (H, 2) as of `FieldOfView.spans`, or empty: all; what counts
    field: NDArray[np.int32],  # the same, of the field: where coarse noise of colour goes
    around: NDArray[np.float32],  # (3, h, w) of `calm_blotches.colors_around`, or empty
    smoothing: np.float32,  # how much of coarse noise goes
    full: np.float32,  # the image's value of 1.0
    sums: NDArray[Any],  # `sums_of` the image
    shading: np.float32,
    bright: NDArray[np.float32],  # (h, w), out: means of calm V in blocks of SUBSAMPLE
    histograms: NDArray[np.int64],  # (tasks, BINS), out: of calm V in grey levels, over the kept pixels
    chroma: NDArray[np.float64],  # (tasks,), out: sum of S over the kept pixels
    absorbed: NDArray[np.float32],  # (h, w), out: `shading` log red - log green, what green lacks
) -> None:
    """Read once; an odd edge repeats what is last."""
    width = held_width(image.shape[1])
    for task in prange(len(chroma)):
        _survey_task(
            task,
            image,
            keep,
            spans,
            field,
            around,
            smoothing,
            full,
            shading,
            bright,
            histograms,
            chroma,
            absorbed,
            np.empty((2, 3, width if smoothing > ZERO else 0), np.float32),
            np.full(2, -1),
            np.empty((2, CHUNK), np.float32),
            np.zeros((ROWS, 3, width), image.dtype),
            np.zeros((ROWS, 3, width), sums.dtype),
            np.zeros((3, CHUNK), sums.dtype),
            zero_chunk(),  # type: ignore[call-arg]
            np.empty(width, np.float32),
            np.empty((2, width), sums.dtype),
            np.empty(CHUNK, np.uint16),
            np.zeros((4, BINS + 1), np.int32),
            np.zeros(CHUNK),
        )


@part(forceinline=True, fastmath={"contract"})
def _survey_task(
    task: int,
    image: NDArray[Any],
    keep: NDArray[np.uint8],
    spans: NDArray[np.int32],
    field: NDArray[np.int32],
    around: NDArray[np.float32],
    smoothing: np.float32,
    full: np.float32,
    shading: np.float32,
    bright: NDArray[np.float32],
    histograms: NDArray[np.int64],
    chroma: NDArray[np.float64],
    absorbed: NDArray[np.float32],
    colors: NDArray[np.float32],
    held_colors: NDArray[np.int64],
    work: NDArray[np.float32],
    lines: NDArray[Any],
    across: NDArray[Any],
    narrow: NDArray[Any],
    chunk: NDArray[np.float32],
    above: NDArray[np.float32],
    pairs: NDArray[Any],
    levels: NDArray[np.uint16],
    counts: NDArray[np.int32],
    totals: NDArray[np.float64],
) -> None:
    """A task's rows; after `absorbed` comes memory to work in."""
    rows, columns = image.shape[0], image.shape[1]
    unit = ONE / full
    reds, greens = pairs[0], pairs[1]
    top, bottom = task * TASK, min((task + 1) * TASK, rows)
    for y in range(top - REACH, top + REACH):
        read_row(image, y, field, full, around, smoothing, colors, held_colors, work, lines, across)
    for y in range(top, bottom):
        read_row(image, y + REACH, field, full, around, smoothing, colors, held_colors, work, lines, across)
        first, end = (spans[y, 0], spans[y, 1]) if len(spans) > 0 else (0, columns)
        chunk[TOTAL] = ZERO
        for x0 in range(0, columns, CHUNK):
            count = min(CHUNK, columns - x0)
            fetch(image, y + REACH + 1, x0)
            calm(lines, across, y, x0, unit, narrow, chunk)
            if first < x0 + count and x0 < end:
                load_keep(keep, y, x0, count, chunk)
                if first > x0 or end < x0 + count:
                    keep_within(first, end, x0, chunk)
                _tally(chunk, levels)
                for i in range(count):
                    counts[i & 3, levels[i]] += np.int32(1)
            low_x, end_x = x0 // SUBSAMPLE, (x0 + count + SUBSAMPLE - 1) // SUBSAMPLE
            if y % SUBSAMPLE == 0:
                _begin(chunk[VALUE], narrow, above[x0:], reds[x0:], greens[x0:])
            if y % SUBSAMPLE == SUBSAMPLE - 1 or y == rows - 1:
                _add(narrow, reds[x0:], greens[x0:])
                if count % SUBSAMPLE != 0:
                    after = x0 + count
                    above[after], chunk[VALUE, count] = above[after - 1], chunk[VALUE, count - 1]
                    reds[after], greens[after] = reds[after - 1], greens[after - 1]
                low_y = y // SUBSAMPLE
                _shrink(above[x0:], chunk[VALUE], bright[low_y, low_x:end_x])
                _absorb(reds[x0:], greens[x0:], unit, shading, absorbed[low_y, low_x:end_x])
        totals += chunk[TOTAL]
    add_up(task, counts, histograms)
    chroma[task] = totals.sum()


@part(forceinline=True, fastmath={"contract"})
def _tally(chunk: NDArray[np.float32], levels: NDArray[np.uint16]) -> None:
    """Add S to its sums; the levels of V, one more than there are of what does not count."""
    wide_vectors()
    for i in range(CHUNK):
        most = chunk[VALUE, i]
        chroma = (most - chunk[LEAST_COLOR, i]) / (most if most > LEAST else LEAST)
        chunk[TOTAL, i] += chunk[KEEP, i] * chroma
        level: np.float32 = rounded(most * LEVELS)  # type: ignore[call-arg]
        levels[i] = np.int32(level if chunk[KEEP, i] > ZERO else LEVELS + ONE)


@part(forceinline=True)
def _begin(
    value: NDArray[np.float32],
    narrow: NDArray[Any],
    above: NDArray[np.float32],
    reds: NDArray[Any],
    greens: NDArray[Any],
) -> None:
    """Keep V and the smoothed colours of the first row of blocks."""
    wide_vectors()
    for i in range(CHUNK):
        above[i] = value[i]
        reds[i], greens[i] = narrow[RED, i], narrow[GREEN, i]


@part(forceinline=True)
def _add(narrow: NDArray[Any], reds: NDArray[Any], greens: NDArray[Any]) -> None:
    """The smoothed colours of the last row of blocks."""
    wide_vectors()
    for i in range(CHUNK):
        reds[i] += narrow[RED, i]
        greens[i] += narrow[GREEN, i]


@part(forceinline=True, fastmath={"contract"})
def _shrink(above: NDArray[np.float32], value: NDArray[np.float32], means: NDArray[np.float32]) -> None:
    """Mean of V in each 2 x 2 block of two rows."""
    wide_vectors()
    for i in range(len(means)):
        x = np.uint64(SUBSAMPLE * i)
        means[i] = (above[x] + above[x + NEXT] + value[x] + value[x + NEXT]) * QUARTER


@part(forceinline=True, fastmath={"contract"})
def _absorb(
    reds: NDArray[Any],
    greens: NDArray[Any],
    unit: np.float32,
    shading: np.float32,
    absorbed: NDArray[np.float32],
) -> None:
    """What green lacks beside red in each 2 x 2 block, from sums over two rows of the smoothed colours."""
    wide_vectors()
    scale = unit * SOFT * QUARTER
    for i in range(len(absorbed)):
        x = np.uint64(SUBSAMPLE * i)
        red = (np.float32(reds[x]) + np.float32(reds[x + NEXT])) * scale
        green = (np.float32(greens[x]) + np.float32(greens[x + NEXT])) * scale
        absorbed[i] = LN_2 * (shading * brief_log2(red + FLOOR) - brief_log2(green + FLOOR))
