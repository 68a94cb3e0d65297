"""The second pass over an image: Eqs 1 and 6-12 in one go, from the chunk that is read to the one written.

Sums are never reordered, so results repeat bit for bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.chunk import (
    BINS,
    BLOCK,
    CHUNK,
    HALF,
    INVERSE,
    KEEP,
    LEAST,
    LEAST_COLOR,
    LEVELS,
    LOG,
    MOST,
    OFFSET,
    ONE,
    PLANES,
    SLOPE,
    TOTAL,
    VALUE,
    ZERO,
    load,
    load_keep,
)
from enhance.interleave import put_together
from enhance.powers import exp2, log2, rounded

FLOOR = np.float32(1 / 255)
BLACK = np.float32(24 / 255)
TWO, THREE = np.float32(2.0), np.float32(3.0)

# What the second pass keeps for the next, or takes from the last.
NOTHING, KEEP_LOGARITHM, FROM_LOGARITHM, KEEP_POWER, FROM_POWER = range(5)


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def render(
    image: NDArray[Any],  # (H, W, 3)
    keep: NDArray[np.uint8],  # (H, W) 0 or 1, or empty: all
    full: np.float32,  # the image's value of 1.0
    subsample: int,
    models: NDArray[np.float32],  # (n, 2, h, w): window means of a and b of each scale
    exponents: NDArray[np.float32],  # (n,) P of each scale; negative: E is left out
    curve: NDArray[np.float32],  # (256,) log2 Vn of each grey level, or empty: by the formula
    z: np.float32,
    pull: np.float32,  # k B / A of Eq 11; negative: S stays
    keep_black: bool,
    pivot: np.float32,  # near the mean of Q
    known: bool,  # `values` is given: only saturation is done
    values: NDArray[np.float32],  # (H, W), V*: in if known, else out; empty: not kept
    stage: int,  # what of `kept` to use or to keep
    kept: NDArray[np.float32],  # (n, H, W): the logarithm of Eq 7's ratio (no P is 1/2), or E
    sums: NDArray[np.float64],  # (H, n, 2), out: of Q - pivot and its square over the kept pixels, or empty
    out: NDArray[Any],  # (H, W, 3), out, of the image's type
) -> None:
    """Second pass: Q, E, V*, S* and the colours, read once and written once."""
    rows, columns = image.shape[0], image.shape[1]
    scales = models.shape[0]
    task = BLOCK * subsample
    width = CHUNK // subsample * subsample  # so that a chunk begins with a low-resolution pixel
    measured = len(sums) > 0
    filters = not known and stage not in (FROM_LOGARITHM, FROM_POWER)
    for block in prange((rows + task - 1) // task):
        chunk = np.empty((PLANES, CHUNK), np.float32)
        apart = np.zeros((5, CHUNK), image.dtype)
        drift = np.empty((scales, CHUNK), np.float32)
        spread = np.empty((scales, CHUNK), np.float32)
        lines = np.empty((2 * scales, models.shape[3] + CHUNK + 2), np.float32)
        for y in range(block * task, min((block + 1) * task, rows)):
            drift[:] = ZERO
            spread[:] = ZERO
            if filters:
                _blend(models, y, subsample, lines)
            for step in range((columns + width - 1) // width):
                x0 = step * width
                count = min(width, columns - x0)
                load(image[y, x0 : x0 + count], apart, chunk)
                for i in range(CHUNK):
                    chunk[VALUE, i] = chunk[MOST, i] / full
                if known:
                    for i in range(count):
                        chunk[TOTAL, i] = values[y, x0 + i]
                else:
                    load_keep(keep, y, x0, count, chunk)
                    _brighten(chunk, apart, curve, z)
                    for i in range(CHUNK):
                        chunk[TOTAL, i] = ZERO
                        chunk[INVERSE, i] = ONE / (chunk[VALUE, i] + FLOOR)
                    start = step * (CHUNK // subsample)
                    for scale in range(scales):
                        p = exponents[scale]
                        if filters and (measured or p >= ZERO):
                            _widen(lines[2 * scale, start:], subsample, chunk, SLOPE)
                            _widen(lines[2 * scale + 1, start:], subsample, chunk, OFFSET)
                            _filter(chunk)
                            if measured:
                                _add_moments(chunk, pivot, drift[scale], spread[scale])
                        if p >= ZERO:
                            _raise(chunk, p, stage, kept[scale, y, x0 : x0 + count])
                            for i in range(CHUNK):
                                chunk[TOTAL, i] += exp2(chunk[SLOPE, i] * chunk[LOG, i])
                    _mean(chunk, exponents)
                    if len(values) > 0:
                        for i in range(count):
                            values[y, x0 + i] = chunk[TOTAL, i]
                _recolor(chunk, pull, full)
                if keep_black and _is_dark(chunk):
                    _fade(chunk, apart)
                _store(chunk, full, apart, out[y, x0 : x0 + count])
            if measured:
                for scale in range(scales):
                    sums[y, scale, 0] = _added(drift[scale])
                    sums[y, scale, 1] = _added(spread[scale])


@njit(inline="always")
def _added(lanes: NDArray[np.float32]) -> float:
    total = 0.0
    for i in range(CHUNK):
        total += np.float64(lanes[i])
    return total


@njit(error_model="numpy")
def _blend(models: NDArray[np.float32], y: int, subsample: int, lines: NDArray[np.float32]) -> None:
    """Every model's row at `y`, between two of low resolution; the border repeats to the left and right."""
    rows, columns = models.shape[2], models.shape[3]
    at = (np.float32(y) + HALF) / np.float32(subsample) - HALF
    at = min(max(at, ZERO), np.float32(rows - 1))
    first = min(int(at), max(rows - 2, 0))
    second = min(first + 1, rows - 1)
    weight = at - np.float32(first)
    for plane in range(len(lines)):
        above, below = models[plane // 2, plane % 2, first], models[plane // 2, plane % 2, second]
        line = lines[plane]
        for x in range(columns):
            line[x + 1] = above[x] + weight * (below[x] - above[x])
        line[0] = line[1]
        for x in range(columns + 1, len(line)):
            line[x] = line[columns]


@njit(inline="always")
def _widen(line: NDArray[np.float32], subsample: int, chunk: NDArray[np.float32], plane: int) -> None:
    """Bring one row of the low resolution up bilinearly; pixel centres aligned."""
    if subsample == 1:
        for i in range(CHUNK):
            chunk[plane, i] = line[i + 1]
    elif subsample == 2:
        _widen_by(line, 2, chunk, plane)
    else:
        _widen_far(line, subsample, chunk, plane)


@njit(fastmath={"contract"}, error_model="numpy")
def _widen_far(line: NDArray[np.float32], subsample: int, chunk: NDArray[np.float32], plane: int) -> None:
    if subsample == 4:
        _widen_by(line, 4, chunk, plane)
    elif subsample == 8:
        _widen_by(line, 8, chunk, plane)
    else:
        _widen_by(line, subsample, chunk, plane)


@njit(inline="always")
def _widen_by(line: NDArray[np.float32], subsample: int, chunk: NDArray[np.float32], plane: int) -> None:
    """One low-resolution pixel a step; where `subsample` is a constant, this becomes vector code."""
    unit = ONE / np.float32(subsample)
    for i in range(CHUNK // subsample):
        left, middle, right = line[i], line[i + 1], line[i + 2]
        for k in range(subsample):
            offset = (np.float32(k) + HALF) * unit - HALF
            near = left if offset < ZERO else right
            chunk[plane, i * subsample + k] = middle + abs(offset) * (near - middle)
    for i in range(CHUNK // subsample * subsample, CHUNK):
        chunk[plane, i] = ZERO


@njit(inline="always")
def _brighten(
    chunk: NDArray[np.float32], apart: NDArray[Any], curve: NDArray[np.float32], z: np.float32
) -> None:
    """log2 of Vn of Eq 1."""
    if len(curve) == BINS:
        for i in range(CHUNK):
            chunk[LOG, i] = curve[np.uint8(apart[3, i])]
    elif z == ONE:
        for i in range(CHUNK):
            chunk[LOG, i] = log2(chunk[VALUE, i])
    else:
        _brighten_directly(chunk, z)


@njit(fastmath={"contract"}, error_model="numpy")
def _brighten_directly(chunk: NDArray[np.float32], z: np.float32) -> None:
    for i in range(CHUNK):
        value = chunk[VALUE, i]
        log = log2(value)
        root = exp2((np.float32(0.75) * z + np.float32(0.25)) * log)
        power = exp2((TWO - z) * log)
        chunk[LOG, i] = log2(HALF * (root + np.float32(0.4) * (ONE - z) * (ONE - value) + power))


@njit(inline="always")
def _filter(chunk: NDArray[np.float32]) -> None:
    """Q of Eq 6, into SLOPE."""
    for i in range(CHUNK):
        chunk[SLOPE, i] = chunk[SLOPE, i] * chunk[VALUE, i] + chunk[OFFSET, i]


@njit(inline="always")
def _add_moments(
    chunk: NDArray[np.float32], pivot: np.float32, drift: NDArray[np.float32], spread: NDArray[np.float32]
) -> None:
    for i in range(CHUNK):
        apart = (chunk[SLOPE, i] - pivot) * chunk[KEEP, i]
        drift[i] += apart
        spread[i] += apart * apart


@njit(inline="always")
def _raise(chunk: NDArray[np.float32], p: np.float32, stage: int, kept: NDArray[np.float32]) -> None:
    """E of Eq 7 from Q, or as far as needed from what is kept of an earlier pass; into SLOPE."""
    if stage in (FROM_LOGARITHM, FROM_POWER):
        for i in range(len(kept)):
            chunk[SLOPE, i] = kept[i]
    else:
        for i in range(CHUNK):
            chunk[SLOPE, i] = (chunk[SLOPE, i] + FLOOR) * chunk[INVERSE, i]
        if p == HALF:
            for i in range(CHUNK):
                chunk[SLOPE, i] = np.sqrt(chunk[SLOPE, i])
        else:
            for i in range(CHUNK):
                chunk[SLOPE, i] = log2(chunk[SLOPE, i])
    if stage == KEEP_LOGARITHM:
        for i in range(len(kept)):
            kept[i] = chunk[SLOPE, i]
    if p != HALF and stage != FROM_POWER:
        for i in range(CHUNK):
            chunk[SLOPE, i] = exp2(p * chunk[SLOPE, i])
    if stage == KEEP_POWER:
        for i in range(len(kept)):
            kept[i] = chunk[SLOPE, i]


@njit(inline="always")
def _mean(chunk: NDArray[np.float32], exponents: NDArray[np.float32]) -> None:
    """V* of Eq 10: of the scales added up, and of Vn for each that is left out, or alone if there is none."""
    left_out = 0
    for scale in range(len(exponents)):
        left_out += 1 if exponents[scale] < ZERO else 0
    if left_out == len(exponents):
        for i in range(CHUNK):
            chunk[TOTAL, i] = exp2(chunk[LOG, i])
        return
    share, missing = ONE / np.float32(len(exponents)), np.float32(left_out)
    if left_out > 0:
        for i in range(CHUNK):
            chunk[TOTAL, i] += missing * exp2(chunk[LOG, i])
    for i in range(CHUNK):
        chunk[TOTAL, i] *= share


@njit(inline="always")
def _recolor(chunk: NDArray[np.float32], pull: np.float32, full: np.float32) -> None:
    """Colours of V* and S* (Eqs 11, 12) with the old hue: c becomes V* (1 - S* (M - c) / D), one division."""
    for i in range(CHUNK):
        most, least = chunk[MOST, i], chunk[LEAST_COLOR, i]
        spread = most - least
        above = spread if pull >= ZERO else ONE
        below = spread * spread + pull * least * least if pull >= ZERO else most
        chunk[SLOPE, i] = above / (below if below > LEAST else LEAST)
    for i in range(CHUNK):
        chunk[OFFSET, i] = chunk[TOTAL, i] * full
    for plane in range(3):
        for i in range(CHUNK):
            apart = chunk[SLOPE, i] * (chunk[MOST, i] - chunk[plane, i])
            chunk[plane, i] = chunk[OFFSET, i] * (ONE - apart)


@njit(inline="always")
def _is_dark(chunk: NDArray[np.float32]) -> bool:
    """Whether any pixel is below V = 24/255; whole numbers, as minima of floats are not reordered."""
    darkest = np.int32(BINS)
    for i in range(CHUNK):
        darkest = min(darkest, np.int32(chunk[VALUE, i] * LEVELS))
    return bool(darkest < 24)


@njit(fastmath={"contract"}, error_model="numpy")
def _fade(chunk: NDArray[np.float32], apart: NDArray[Any]) -> None:
    """`keep_black`: back to the original colours below V = 24/255, by a smoothstep that is 0 at V = 0."""
    for i in range(CHUNK):
        t = chunk[VALUE, i] * (ONE / BLACK)
        t = t if t < ONE else ONE
        chunk[OFFSET, i] = t * t * (THREE - TWO * t)
    for plane in range(3):
        for i in range(CHUNK):
            weight = chunk[OFFSET, i]
            chunk[plane, i] = weight * chunk[plane, i] + (ONE - weight) * np.float32(apart[plane, i])


@njit(inline="always")
def _store(chunk: NDArray[np.float32], full: np.float32, apart: NDArray[Any], pixels: NDArray[Any]) -> None:
    for plane in range(3):
        for i in range(CHUNK):
            color = chunk[plane, i]
            color = color if color < full else full
            color = color if color > ZERO else ZERO
            apart[plane, i] = rounded(color) if full > ONE else color  # type: ignore[call-arg]
    put_together(apart, pixels)
