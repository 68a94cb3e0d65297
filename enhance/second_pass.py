"""The second pass over an image: Eqs 1 and 6-12 in one go, from the chunk that is read to the one written.

Sums are never reordered, so results repeat bit for bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.part import part
from enhance.pixel_block import (
    BINS,
    BLOCK,
    CHUNK,
    HALF,
    INVERSE,
    KEEP,
    LOG,
    MOST,
    ONE,
    SLOPE,
    STEP,
    TOTAL,
    TWO,
    VALUE,
    ZERO,
    copy_pixels,
    copy_row,
    keep_within,
    load,
    load_keep,
    zero_chunk,
    zero_row,
)
from enhance.powers import exp2, log2
from enhance.prefetch import fetch
from enhance.recolor import fade, is_dark, recolor, store
from enhance.upscale import bring_up
from enhance.wide_vectors import wide_vectors

FLOOR = np.float32(1 / 255)
SUMMED = 4
"""Rows of which float32 sums Q; the sums are added up in float64."""

# What the second pass keeps for the next, or takes from the last.
NOTHING, KEEP_LOGARITHM, FROM_LOGARITHM, KEEP_POWER, FROM_POWER = range(5)


@njit(parallel=True, nogil=True, cache=True, fastmath={"contract"}, error_model="numpy")
def render(
    image: NDArray[Any],  # (H, W, 3)
    keep: NDArray[np.uint8],  # (H, W) 0 or 1, or empty: all
    spans: NDArray[np.int32],  # (H, 2) of `FieldOfView.spans`, or empty: all
    full: np.float32,  # the image's value of 1.0
    subsample: int,
    fine: NDArray[np.float32],  # (n, 2, h, w): window means of a and b of each scale on the fine grid
    coarse: NDArray[np.float32],  # (n, 2, h / 2, w / 2): of each on the coarse one
    is_coarse: NDArray[np.bool_],  # (n,)
    filtered: NDArray[np.bool_],  # (n,): Q is needed
    measured: NDArray[np.bool_],  # (n,): and its sums
    exponents: NDArray[np.float32],  # (n,) P of each scale; negative: E is left out
    curve: NDArray[np.float32],  # (256,) log2 Vn of each grey level, or empty: by the formula
    z: np.float32,
    pull: np.float32,  # k B / A of Eq 11; negative: S stays
    color: np.float32,  # share of S* in place of S, in [0, 1]
    keep_black: bool,
    pivot: np.float32,  # near the mean of Q
    known: bool,  # `values` is given: only saturation is done
    values: NDArray[np.float32],  # (H, W), V*: in if known, else out; empty: not kept
    stages: NDArray[np.int64],  # (n,) what of `kept` to use or to keep
    kept: NDArray[np.float32],  # (n, H, W): the logarithm of Eq 7's ratio (P is not 1/2), or E
    sums: NDArray[np.float64],  # (blocks, n, 2), out: of Q - pivot and its square over the kept pixels
    out: NDArray[Any],  # (H, W, 3), out, of the image's type
    totals: NDArray[np.float64],  # (n, 2), out: `sums` together
) -> None:
    """Second pass: Q, E, V*, S* and the colours, read once and written once."""
    columns, scales = image.shape[1], len(exponents)
    width = (columns + CHUNK - 1) // CHUNK * CHUNK + (2 * subsample + STEP - 1) // STEP * STEP
    for block in prange(len(sums)):
        _render_block(
            block,
            image,
            keep,
            spans,
            full,
            subsample,
            fine,
            coarse,
            is_coarse,
            filtered,
            measured,
            exponents,
            curve,
            z,
            pull,
            color,
            keep_black,
            pivot,
            known,
            values,
            stages,
            kept,
            sums[block],
            out,
            zero_chunk(),  # type: ignore[call-arg]
            zero_row(5 * CHUNK, image.dtype).reshape((5, CHUNK)),  # type: ignore[call-arg]
            np.empty(scales, np.float32),
            zero_row(4 * scales * width, np.float32).reshape((scales, 2, 2, width)),  # type: ignore[call-arg]
            np.full((scales, 2), -1),
            zero_row(2 * scales * CHUNK, np.float32).reshape((scales, 2, CHUNK)),  # type: ignore[call-arg]
            np.zeros((scales, 2, CHUNK)),
        )
    _add_up(sums, totals)


@part(forceinline=True, fastmath={"contract"})
def _render_block(
    block: int,
    image: NDArray[Any],
    keep: NDArray[np.uint8],
    spans: NDArray[np.int32],
    full: np.float32,
    subsample: int,
    fine: NDArray[np.float32],
    coarse: NDArray[np.float32],
    is_coarse: NDArray[np.bool_],
    filtered: NDArray[np.bool_],
    measured: NDArray[np.bool_],
    exponents: NDArray[np.float32],
    curve: NDArray[np.float32],
    z: np.float32,
    pull: np.float32,
    color: np.float32,
    keep_black: bool,
    pivot: np.float32,
    known: bool,
    values: NDArray[np.float32],
    stages: NDArray[np.int64],
    kept: NDArray[np.float32],
    sums: NDArray[np.float64],
    out: NDArray[Any],
    chunk: NDArray[np.float32],
    apart: NDArray[Any],
    weights: NDArray[np.float32],
    lines: NDArray[np.float32],
    held: NDArray[np.int64],
    moments: NDArray[np.float32],
    totals: NDArray[np.float64],
) -> None:
    """A task's rows; after `out` comes memory to work in.

    lines: of each scale, the rows of its models on either side of y, the even one first, brought up to width.
    """
    rows, columns = image.shape[0], image.shape[1]
    scales = len(exponents)
    task = BLOCK * subsample
    unit = ONE / full
    top, bottom = block * task, min((block + 1) * task, rows)
    for y in range(top, bottom):
        first, end = (spans[y, 0], spans[y, 1]) if len(spans) > 0 else (0, columns)
        for scale in range(scales):
            if filtered[scale]:
                models = coarse[scale] if is_coarse[scale] else fine[scale]
                grid = 2 * subsample if is_coarse[scale] else subsample
                weights[scale] = bring_up(models, y, grid, lines[scale], held[scale])
        for step in range(first // CHUNK, (end + CHUNK - 1) // CHUNK if end > first else 0):
            x0 = step * CHUNK
            count = min(CHUNK, columns - x0)
            load(image[y, x0 : x0 + count], apart, chunk)
            fetch(image, y, x0 + CHUNK)
            fetch(out, y, x0 + CHUNK)
            _set_value(chunk, unit)
            if known:
                fetch(values, y, x0 + CHUNK)
                copy_row(values[y, x0:], chunk[TOTAL, :count])
            else:
                load_keep(keep, y, x0, count, chunk)
                if first > x0 or end < x0 + count:
                    keep_within(first, end, x0, chunk)
                _brighten(chunk, apart, curve, z)
                _begin(chunk)
                for scale in range(scales):
                    p = exponents[scale]
                    by_root = p == HALF and stages[scale] == NOTHING
                    if by_root and filtered[scale] and measured[scale]:
                        filter_and_add_by_root(lines[scale], x0, weights[scale], pivot, moments[scale], chunk)
                        continue
                    if filtered[scale]:
                        filter_row(lines[scale], x0, weights[scale], chunk)
                        if measured[scale]:
                            add_moments(chunk, pivot, moments[scale])
                    if by_root:
                        _add_by_root(chunk)
                    elif p >= ZERO:
                        if stages[scale] != NOTHING:
                            fetch(kept[scale], y, x0 + CHUNK)
                        _raise(chunk, p, stages[scale], kept[scale, y, x0 : x0 + count])
                        _add_power(chunk)
                _mean(chunk, exponents)
                if len(values) > 0:
                    copy_row(chunk[TOTAL], values[y, x0 : x0 + count])
            recolor(chunk, apart, pull, color, full)
            if keep_black and is_dark(chunk):
                fade(chunk, apart)
            store(chunk, full, apart, out[y, x0 : x0 + count])
        copy_pixels(image[y, :first], out[y, :first])
        copy_pixels(image[y, end:], out[y, end:])
        if (y - top) % SUMMED == SUMMED - 1 or y == bottom - 1:
            _pour(moments, totals)
    _total(totals, sums)


@part()
def _pour(moments: NDArray[np.float32], totals: NDArray[np.float64]) -> None:
    """Add sums (n, 2, CHUNK) of some rows to those of all; they begin anew."""
    wide_vectors()
    parts, wholes = moments.reshape(-1), totals.reshape(-1)
    for i in range(len(parts)):
        wholes[i] += parts[i]
        parts[i] = ZERO


@part()
def _total(totals: NDArray[np.float64], sums: NDArray[np.float64]) -> None:
    """From (n, 2, CHUNK) to (n, 2)."""
    for scale in range(len(totals)):
        drift, spread = 0.0, 0.0
        for i in range(CHUNK):
            drift += totals[scale, 0, i]
            spread += totals[scale, 1, i]
        sums[scale, 0], sums[scale, 1] = drift, spread


@part()
def _add_up(sums: NDArray[np.float64], totals: NDArray[np.float64]) -> None:
    """Of all tasks, from the top of the image down."""
    totals[:] = 0.0
    for task in range(len(sums)):
        totals += sums[task]


@part(forceinline=True, fastmath={"contract"})
def _set_value(chunk: NDArray[np.float32], unit: np.float32) -> None:
    wide_vectors()
    for i in range(CHUNK):
        chunk[VALUE, i] = chunk[MOST, i] * unit


@part(forceinline=True, fastmath={"contract"})
def _begin(chunk: NDArray[np.float32]) -> None:
    """What Eq 7 divides by, and no V* yet."""
    wide_vectors()
    for i in range(CHUNK):
        chunk[INVERSE, i] = ONE / (chunk[VALUE, i] + FLOOR)
        chunk[TOTAL, i] = ZERO


@part(forceinline=True, fastmath={"contract"})
def _add_power(chunk: NDArray[np.float32]) -> None:
    wide_vectors()
    for i in range(CHUNK):
        chunk[TOTAL, i] += exp2(chunk[SLOPE, i] * chunk[LOG, i])


@part(forceinline=True, fastmath={"contract"})
def filter_row(lines: NDArray[np.float32], x0: int, weight: np.float32, chunk: NDArray[np.float32]) -> None:
    """Q of Eq 6, into SLOPE, between two rows of a and b."""
    wide_vectors()
    a, a_odd = lines[0, 0, x0 : x0 + CHUNK], lines[1, 0, x0 : x0 + CHUNK]
    b, b_odd = lines[0, 1, x0 : x0 + CHUNK], lines[1, 1, x0 : x0 + CHUNK]
    for i in range(CHUNK):
        slope = a[i] + weight * (a_odd[i] - a[i])
        offset = b[i] + weight * (b_odd[i] - b[i])
        chunk[SLOPE, i] = slope * chunk[VALUE, i] + offset


@part(forceinline=True, fastmath={"contract"})
def _brighten(
    chunk: NDArray[np.float32], apart: NDArray[Any], curve: NDArray[np.float32], z: np.float32
) -> None:
    """log2 of Vn of Eq 1."""
    wide_vectors()
    if len(curve) == BINS:
        for i in range(CHUNK):
            chunk[LOG, i] = curve[np.uint8(apart[3, i])]
    elif z == ONE:
        for i in range(CHUNK):
            chunk[LOG, i] = log2(chunk[VALUE, i])
    else:
        _brighten_directly(chunk, z)


@part(fastmath={"contract"})
def _brighten_directly(chunk: NDArray[np.float32], z: np.float32) -> None:
    wide_vectors()
    for i in range(CHUNK):
        value = chunk[VALUE, i]
        log = log2(value)
        root = exp2((np.float32(0.75) * z + np.float32(0.25)) * log)
        power = exp2((TWO - z) * log)
        chunk[LOG, i] = log2(HALF * (root + np.float32(0.4) * (ONE - z) * (ONE - value) + power))


@part(forceinline=True, fastmath={"contract"})
def add_moments(
    chunk: NDArray[np.float32],
    pivot: np.float32,
    sums: NDArray[np.float32],  # (2, CHUNK), in and out: of Q - pivot and its square over the kept pixels
) -> None:
    wide_vectors()
    drift, spread = sums[0], sums[1]
    for i in range(CHUNK):
        apart = (chunk[SLOPE, i] - pivot) * chunk[KEEP, i]
        drift[i] += apart
        spread[i] += apart * apart


@part(forceinline=True, fastmath={"contract"})
def filter_and_add_by_root(
    lines: NDArray[np.float32],
    x0: int,
    weight: np.float32,
    pivot: np.float32,
    sums: NDArray[np.float32],  # (2, CHUNK), in and out
    chunk: NDArray[np.float32],
) -> None:
    """`filter_row`, `add_moments` and Vn^E for P = 1/2, nearly every image's, in one go."""
    wide_vectors()
    a, a_odd = lines[0, 0, x0 : x0 + CHUNK], lines[1, 0, x0 : x0 + CHUNK]
    b, b_odd = lines[0, 1, x0 : x0 + CHUNK], lines[1, 1, x0 : x0 + CHUNK]
    drift, spread = sums[0], sums[1]
    for i in range(CHUNK):
        slope = a[i] + weight * (a_odd[i] - a[i])
        offset = b[i] + weight * (b_odd[i] - b[i])
        filtered = slope * chunk[VALUE, i] + offset
        apart = (filtered - pivot) * chunk[KEEP, i]
        drift[i] += apart
        spread[i] += apart * apart
        ratio = (filtered + FLOOR) * chunk[INVERSE, i]
        chunk[TOTAL, i] += exp2(np.sqrt(ratio) * chunk[LOG, i])


@part(forceinline=True, fastmath={"contract"})
def _add_by_root(chunk: NDArray[np.float32]) -> None:
    """Vn^E of Eq 8 from Q for P = 1/2, onto TOTAL."""
    wide_vectors()
    for i in range(CHUNK):
        ratio = (chunk[SLOPE, i] + FLOOR) * chunk[INVERSE, i]
        chunk[TOTAL, i] += exp2(np.sqrt(ratio) * chunk[LOG, i])


@part(forceinline=True, fastmath={"contract"})
def _raise(chunk: NDArray[np.float32], p: np.float32, stage: int, kept: NDArray[np.float32]) -> None:
    """E of Eq 7 from Q, or as far as needed from what is kept of an earlier pass; into SLOPE."""
    wide_vectors()
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


@part(forceinline=True, fastmath={"contract"})
def _mean(chunk: NDArray[np.float32], exponents: NDArray[np.float32]) -> None:
    """V* of Eq 10: of the scales added up, and of Vn for each that is left out, or alone if there is none."""
    wide_vectors()
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
