"""The first pass of the preset `vessel`: noise of colour goes, and what the statistics, the filters and the
search for blood need is gathered.

Sums are never reordered, so results repeat bit for bit.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.first_pass import pool
from enhance.interleave import deinterleave
from enhance.pixel_block import (
    BINS,
    BLOCK,
    BLUE,
    CHUNK,
    GREEN,
    INVERSE,
    KEEP,
    LEAST,
    LEAST_COLOR,
    LEVELS,
    LOG,
    MOST,
    ONE,
    PLANES,
    RED,
    SLOPE,
    TOTAL,
    VALUE,
    ZERO,
    keep_within,
    load_keep,
)
from enhance.powers import log2, rounded
from enhance.rows import (
    BROAD,
    NARROW,
    REACH,
    READ,
    ROWS,
    add_down_narrowly,
    add_down_widely,
    held_width,
    read_row,
)

SUBSAMPLE: Final = 2
"""Of the guided filters, as by default."""
TASK: Final = SUBSAMPLE * BLOCK
"""Rows of one task."""
LUMA = (np.float32(0.299), np.float32(0.587), np.float32(0.114))
FLOOR = np.float32(8 / 255)
"""Added before a logarithm, so that noise in the dark is no structure."""
LN_2 = np.float32(np.log(2))
QUARTER = np.float32(0.25)
NEXT = np.uint64(1)


@njit(parallel=True, nogil=True, cache=True, fastmath={"contract"}, error_model="numpy")
def first_pass(
    image: NDArray[Any],  # (H, W, 3)
    keep: NDArray[np.uint8],  # (H, W) 0 or 1, or empty: all
    spans: NDArray[np.int32],  # (H, 2) of `FieldOfView.spans`, or empty: all
    full: np.float32,  # the image's value of 1.0
    sums: NDArray[Any],  # `sums_of` the image
    shading: np.float32,
    step: int,  # of `small`
    fine: NDArray[np.float32],  # (2, h, w), out: of calm V in blocks of SUBSAMPLE, mean and variance
    coarse: NDArray[np.float32],  # (2, h / 2, w / 2) rounded up, out: the same of 2 x 2 blocks
    histograms: NDArray[np.int64],  # (tasks, BINS), out: of calm V in grey levels, over the kept pixels
    chroma: NDArray[np.float64],  # (tasks,), out: sum of S over the kept pixels
    absorbed: NDArray[np.float32],  # (H, W), out: `shading` log red - log green, what green lacks
    small: NDArray[np.float32],  # (H / step, W / step) rounded up, out: its means over blocks
) -> None:
    """Read once; an odd edge repeats what is last."""
    rows, columns = image.shape[0], image.shape[1]
    low_rows = fine.shape[1]
    unit = ONE / full
    for task in prange(len(chroma)):
        width = held_width(columns)
        line = np.zeros((3, width), image.dtype)
        across = np.zeros((ROWS, 3, width), sums.dtype)
        apart, narrow = np.zeros((3, CHUNK), image.dtype), np.zeros((3, CHUNK), sums.dtype)
        down = np.zeros((2, READ), sums.dtype)
        chunk = np.zeros((PLANES, CHUNK), np.float32)
        above, piles = np.empty(width, np.float32), np.empty(width, np.float32)
        levels = np.empty(CHUNK, np.uint16)
        counts = np.zeros((4, BINS + 1), np.int32)
        blocks = np.empty((2, CHUNK), np.float32)
        totals = np.zeros(CHUNK)
        top, bottom = task * TASK, min((task + 1) * TASK, rows)
        for y in range(top - REACH, top + REACH):
            read_row(image, y, line, across)
        for y in range(top, bottom):
            read_row(image, y + REACH, line, across)
            first, end = (spans[y, 0], spans[y, 1]) if len(spans) > 0 else (0, columns)
            chunk[TOTAL] = ZERO
            for x0 in range(0, columns, CHUNK):
                count = min(CHUNK, columns - x0)
                calm(image[y, x0 : x0 + count], across, y, x0, unit, apart, narrow, chunk)
                if first < x0 + count and x0 < end:
                    load_keep(keep, y, x0, count, chunk)
                    if first > x0 or end < x0 + count:
                        keep_within(first, end, x0, chunk)
                    _tally(chunk, levels)
                    for i in range(count):
                        counts[i & 3, levels[i]] += np.int32(1)
                _absorb(across, y, x0, unit, shading, down, chunk)
                for i in range(count):
                    absorbed[y, x0 + i] = chunk[SLOPE, i]
                _pile_up(chunk, y, count, rows, step, piles[x0:], small[y // step, x0 // step :])
                if y % SUBSAMPLE == SUBSAMPLE - 1 or y == rows - 1:
                    _shrink(chunk, y % SUBSAMPLE == 0, count, above[x0:], blocks)
                    low_x = x0 // SUBSAMPLE
                    for plane in range(2):
                        for i in range((count + SUBSAMPLE - 1) // SUBSAMPLE):
                            fine[plane, y // SUBSAMPLE, low_x + i] = blocks[plane, i]
                else:
                    for i in range(CHUNK):
                        above[x0 + i] = chunk[VALUE, i]
            totals += chunk[TOTAL]
        last = min((task + 1) * BLOCK, low_rows)
        for low_row in range(task * BLOCK // 2, (last + 1) // 2):
            pool(fine, 2 * low_row, min(2 * low_row + 1, low_rows - 1), coarse[:, low_row])
        chroma[task] = totals.sum()
        for level in range(BINS):
            histograms[task, level] = (
                counts[0, level] + counts[1, level] + counts[2, level] + counts[3, level]
            )


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def calm(
    pixels: NDArray[Any],  # (count, 3) of row y, from column x0 on
    across: NDArray[Any],
    y: int,
    x0: int,
    unit: np.float32,
    apart: NDArray[Any],  # (3, CHUNK), for use here
    narrow: NDArray[Any],  # (3, CHUNK), for use here
    chunk: NDArray[np.float32],
) -> None:
    """Noise of colour goes, that of brightness stays: differences of R, G and B to luma are smoothed.

    The calm colours, their largest as MOST and V, and their smallest; V never rises by it.
    """
    deinterleave(pixels, apart)
    for color in range(3):
        add_down_narrowly(across, y, color, x0, narrow[color])
    scale = unit * NARROW
    for i in range(CHUNK):
        soft_red, soft_green = np.float32(narrow[0, i]) * scale, np.float32(narrow[1, i]) * scale
        soft_blue = np.float32(narrow[2, i]) * scale
        red, green = np.float32(apart[0, i]) * unit, np.float32(apart[1, i]) * unit
        blue = np.float32(apart[2, i]) * unit
        fine = LUMA[0] * (red - soft_red) + LUMA[1] * (green - soft_green) + LUMA[2] * (blue - soft_blue)
        most = red if red > green else green
        most = most if most > blue else blue
        red, green, blue = soft_red + fine, soft_green + fine, soft_blue + fine
        red, green = red if red < most else most, green if green < most else most
        blue = blue if blue < most else most
        red, green = red if red > ZERO else ZERO, green if green > ZERO else ZERO
        blue = blue if blue > ZERO else ZERO
        value = red if red > green else green
        value = value if value > blue else blue
        least = red if red < green else green
        chunk[RED, i], chunk[GREEN, i], chunk[BLUE, i] = red, green, blue
        chunk[MOST, i], chunk[VALUE, i] = value, value
        chunk[LEAST_COLOR, i] = least if least < blue else blue


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _tally(chunk: NDArray[np.float32], levels: NDArray[np.uint16]) -> None:
    """Add S to its sums; the levels of V, one more than there are of what does not count."""
    for i in range(CHUNK):
        most = chunk[VALUE, i]
        chroma = (most - chunk[LEAST_COLOR, i]) / (most if most > LEAST else LEAST)
        chunk[TOTAL, i] += chunk[KEEP, i] * chroma
        level: np.float32 = rounded(most * LEVELS)  # type: ignore[call-arg]
        levels[i] = np.int32(level if chunk[KEEP, i] > ZERO else LEVELS + ONE)


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _shrink(
    chunk: NDArray[np.float32],
    alone: bool,
    count: int,
    above: NDArray[np.float32],
    blocks: NDArray[np.float32],
) -> None:
    """Mean and variance of V in each 2 x 2 block, from the row before, if there is one, and VALUE."""
    for i in range(CHUNK):
        chunk[LOG, i] = chunk[VALUE, i] if alone else above[i]
    if count % SUBSAMPLE != 0:
        chunk[LOG, count], chunk[VALUE, count] = chunk[LOG, count - 1], chunk[VALUE, count - 1]
    for i in range(CHUNK // SUBSAMPLE):
        x = np.uint64(SUBSAMPLE * i)
        a, b = chunk[LOG, x], chunk[LOG, x + NEXT]
        c, d = chunk[VALUE, x], chunk[VALUE, x + NEXT]
        mean = (a + b + c + d) * QUARTER
        a, b, c, d = a - mean, b - mean, c - mean, d - mean
        blocks[0, i], blocks[1, i] = mean, (a * a + b * b + (c * c + d * d)) * QUARTER


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _absorb(
    across: NDArray[Any],
    y: int,
    x0: int,
    unit: np.float32,
    shading: np.float32,
    down: NDArray[Any],
    chunk: NDArray[np.float32],
) -> None:
    """What green lacks beside red, widely smoothed, into SLOPE."""
    add_down_widely(across, y, RED, x0, down[RED])
    add_down_widely(across, y, GREEN, x0, down[GREEN])
    scale = unit * BROAD
    for i in range(CHUNK):
        x, x1, x2 = np.uint64(i), np.uint64(i) + NEXT, np.uint64(i) + NEXT + NEXT
        red = np.float32(down[RED, x] + down[RED, x2] + (down[RED, x1] + down[RED, x1])) * scale
        green = np.float32(down[GREEN, x] + down[GREEN, x2] + (down[GREEN, x1] + down[GREEN, x1])) * scale
        chunk[SLOPE, i] = LN_2 * (shading * log2(red + FLOOR) - log2(green + FLOOR))


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _pile_up(
    chunk: NDArray[np.float32],
    y: int,
    count: int,
    rows: int,
    step: int,
    pile: NDArray[np.float32],
    small: NDArray[np.float32],
) -> None:
    """Add SLOPE to the sums of blocks' columns, and finish the blocks with their last row."""
    for x in range(count, min((count + step - 1) // step * step, CHUNK)):
        chunk[SLOPE, x] = chunk[SLOPE, count - 1]
    if y % step == 0:
        for i in range(CHUNK):
            pile[i] = chunk[SLOPE, i]
    else:
        for i in range(CHUNK):
            pile[i] += chunk[SLOPE, i]
    if y % step == step - 1 or y == rows - 1:
        missing = np.float32(step - 1 - y % step)
        scale = ONE / np.float32(step * step)
        for i in range(CHUNK):
            chunk[INVERSE, i] = (pile[i] + missing * chunk[SLOPE, i]) * scale
        if step == 2:
            _fold(chunk[INVERSE], 2, count, small)
        else:
            _fold(chunk[INVERSE], step, count, small)


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _fold(sums: NDArray[np.float32], step: int, count: int, small: NDArray[np.float32]) -> None:
    for x in range((count + step - 1) // step):
        total = ZERO
        for k in range(step):
            total += sums[np.uint64(x * step + k)]
        small[x] = total
