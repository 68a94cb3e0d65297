"""The second pass of the preset `vessel`: brightness, detail and colour, then the attenuation by blood.

All in one go, from the chunk that is read to the one written. Sums are never reordered, so results repeat
bit for bit.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance import vessel_curves
from enhance.pixel_block import (
    BLUE,
    CHUNK,
    GREEN,
    HALF,
    INVERSE,
    LEAST_COLOR,
    LOG,
    ONE,
    PLANES,
    RED,
    SLOPE,
    TOTAL,
    TWO,
    VALUE,
    ZERO,
    copy_pixels,
    keep_within,
    load_keep,
)
from enhance.powers import LOG2_E, brief_exp2, brief_log2
from enhance.rows import REACH, ROWS, held_width, read_row
from enhance.second_pass import (
    FLOOR,
    add_moments,
    faded_to_black,
    filter_and_add_by_root,
    filter_row,
    store,
)
from enhance.upscale import bring_up
from enhance.vessel_curves import faded, unpacked, value_of
from enhance.vessel_first_pass import SUBSAMPLE, TASK, calm_color, extremes, gather

ABSORPTION: Final = np.array([0.15, 1.0, 0.8], dtype=np.float32)
"""Of haemoglobin in the red, green and blue of a camera, relative to green (coarse: sensors differ)."""
TWENTY = np.float32(20.0)
LOWEST, DIM = np.float32(vessel_curves.LOWEST), np.float32(vessel_curves.DIM)
TINY = np.float32(1e-6)
LEAST_SQUARE = np.float32(1e-12)


@njit(parallel=True, nogil=True, cache=True, fastmath={"contract"}, error_model="numpy")
def second_pass(
    image: NDArray[Any],  # (H, W, 3)
    keep: NDArray[np.uint8],  # (H, W) 0 or 1, or empty: all
    spans: NDArray[np.int32],  # (H, 2) of `FieldOfView.spans`, or empty: all; outside, `image` stays
    full: np.float32,  # the image's value of 1.0
    sums_type: NDArray[Any],  # `sums_of` the image
    fine: NDArray[np.float32],  # (n, 2, h, w): window means of a and b of each scale on the fine grid
    coarse: NDArray[np.float32],  # (n, 2, h / 2, w / 2): of each on the coarse one
    is_coarse: NDArray[np.bool_],  # (n,)
    exponents: NDArray[np.float32],  # (n,) P of each scale
    logarithms: NDArray[np.float32],  # of log2 Vn by log2 V, see `vessel_curves`
    pivot: np.float32,  # near the mean of Q
    density: NDArray[np.float32],  # (1, h, w) of blood, in [0, `vessel_density.BOUND`]
    powers: NDArray[np.float32],  # of V^gamma by V
    pull: np.float32,  # k B / A of Eq 11; negative: S stays
    most_color: np.float32,  # bound on the gain of S
    strength: np.float32,
    is_grey: bool,  # all three lose the whole density
    moments: NDArray[np.float64],  # (tasks, n, 2), out: of Q - pivot and its square over the kept pixels
    out: NDArray[Any],  # (H, W, 3), out, of the image's type
) -> None:
    """See `enhance.vessel.enhance_vessels`."""
    rows, columns = image.shape[0], image.shape[1]
    scales = len(exponents)
    unit = ONE / full
    for task in prange(len(moments)):
        width = held_width(columns)
        line = np.zeros((3, width), image.dtype)
        across = np.zeros((ROWS, 3, width), sums_type.dtype)
        apart, narrow = np.zeros((3, CHUNK), image.dtype), np.zeros((3, CHUNK), sums_type.dtype)
        chunk = np.zeros((PLANES, CHUNK), np.float32)
        lines = np.zeros((scales, 2, 2, width + 2 * SUBSAMPLE), np.float32)
        blood = np.zeros((2, 1, width + SUBSAMPLE), np.float32)
        held, held_blood = np.full((scales, 2), -1), np.full(2, -1)
        weights = np.empty(scales, np.float32)
        sums = np.empty((scales, 2, CHUNK), np.float32)
        totals = np.zeros((scales, 2, CHUNK))
        top, bottom = task * TASK, min((task + 1) * TASK, rows)
        for y in range(top - REACH, top + REACH):
            read_row(image, y, line, across)
        for y in range(top, bottom):
            read_row(image, y + REACH, line, across)
            first, end = (spans[y, 0], spans[y, 1]) if len(spans) > 0 else (0, columns)
            for scale in range(scales):
                models = coarse[scale] if is_coarse[scale] else fine[scale]
                grid = 2 * SUBSAMPLE if is_coarse[scale] else SUBSAMPLE
                weights[scale] = bring_up(models, y, grid, lines[scale], held[scale])
            weight = bring_up(density, y, SUBSAMPLE, blood, held_blood)
            sums[:] = ZERO
            for x0 in range(first // CHUNK * CHUNK, end if end > first else 0, CHUNK):
                count = min(CHUNK, columns - x0)
                gather(image[y, x0 : x0 + count], across, y, x0, apart, narrow)
                for i in range(CHUNK):
                    red, green, blue = calm_color(apart, narrow, i, unit)
                    chunk[RED, i], chunk[GREEN, i], chunk[BLUE, i] = red, green, blue
                    chunk[VALUE, i], chunk[LEAST_COLOR, i] = extremes(red, green, blue)
                load_keep(keep, y, x0, count, chunk)
                if first > x0 or end < x0 + count:
                    keep_within(first, end, x0, chunk)
                _begin(chunk, logarithms)
                for scale in range(scales):
                    p, weight_of = exponents[scale], weights[scale]
                    if p == HALF:
                        filter_and_add_by_root(lines[scale], x0, weight_of, pivot, sums[scale], chunk)
                    else:
                        filter_row(lines[scale], x0, weight_of, chunk)
                        add_moments(chunk, pivot, sums[scale])
                        _add_by_power(chunk, p)
                _finish(
                    chunk, powers, ONE / np.float32(scales), pull, most_color,
                    blood[0, 0, x0:], blood[1, 0, x0:], weight, strength, is_grey, full,
                )  # fmt: skip
                store(chunk, full, apart, out[y, x0 : x0 + count])
            copy_pixels(image[y, :first], out[y, :first])
            copy_pixels(image[y, end:], out[y, end:])
            totals += sums
        for scale in range(scales):
            moments[task, scale, 0] = totals[scale, 0].sum()
            moments[task, scale, 1] = totals[scale, 1].sum()


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _begin(chunk: NDArray[np.float32], logarithms: NDArray[np.float32]) -> None:
    """log2 of Vn of Eq 1, and what the scales need."""
    terms = unpacked(logarithms)
    for i in range(CHUNK):
        value = chunk[VALUE, i]
        log = brief_log2(value)
        chunk[LOG, i] = value_of(terms, (log if log > LOWEST else LOWEST) * (-TWO / LOWEST) + ONE)
        chunk[INVERSE, i] = ONE / (value + FLOOR)
        chunk[TOTAL, i] = ZERO


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _add_by_power(chunk: NDArray[np.float32], p: np.float32) -> None:
    """Vn^E of Eq 8 from Q in SLOPE, onto TOTAL."""
    for i in range(CHUNK):
        power = brief_exp2(p * brief_log2((chunk[SLOPE, i] + FLOOR) * chunk[INVERSE, i]))
        chunk[TOTAL, i] += brief_exp2(power * chunk[LOG, i])


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _finish(
    chunk: NDArray[np.float32],
    powers: NDArray[np.float32],
    share: np.float32,  # of each scale in V*
    pull: np.float32,
    most_color: np.float32,
    even: NDArray[np.float32],  # rows of the density on either side
    odd: NDArray[np.float32],
    weight: np.float32,
    strength: np.float32,
    is_grey: bool,
    full: np.float32,
) -> None:
    """Colours of V* and the gain of S, less what blood takes, times the value that means 1.0.

    ABSORPTION in twentieths is whole, so powers of one exponential serve for three.
    """
    terms = unpacked(powers)
    taken = -LOG2_E / TWENTY * strength
    for i in range(CHUNK):
        value = chunk[VALUE, i]
        bright = _deepened(chunk[TOTAL, i] * share, value, terms)
        fall = bright * _color_gain(value, chunk[LEAST_COLOR, i], pull, most_color)
        power = brief_exp2(taken * (even[i] + weight * (odd[i] - even[i])))
        second = power * power
        fourth = second * second
        eighth = fourth * fourth
        for_blue = eighth * eighth
        for_green = for_blue * fourth
        red, green = bright - fall * (value - chunk[RED, i]), bright - fall * (value - chunk[GREEN, i])
        blue = bright - fall * (value - chunk[BLUE, i])
        chunk[RED, i] = red * ((for_green if is_grey else second * power) * full)
        chunk[GREEN, i] = green * (for_green * full)
        chunk[BLUE, i] = blue * ((for_green if is_grey else for_blue) * full)


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _deepened(bright: np.float32, value: np.float32, terms: tuple[np.float32, ...]) -> np.float32:
    """V* of the mean over scales, black kept, and `gamma` where it is not dark."""
    bright = value + faded_to_black(value) * (bright - value)
    bright = bright if bright < ONE else ONE
    deep = value_of(terms, (bright - DIM) * (TWO / (ONE - DIM)) - ONE)
    return bright + faded(bright) * (deep - bright)


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _color_gain(most: np.float32, least: np.float32, pull: np.float32, most_color: np.float32) -> np.float32:
    """Of S between 1 and its bound, over `most`; the hue stays.

    With M and D the largest and the spread of a pixel's channels, S* / S = M D / (D^2 + pull m^2).
    """
    spread = most - least
    spread = spread if spread > TINY * most else TINY * most
    below = spread * spread + pull * least * least
    below = below if below > LEAST_SQUARE * LEAST_SQUARE else LEAST_SQUARE * LEAST_SQUARE
    most = most if most > TINY else TINY
    of_both = ONE / (most * below)  # One division for two.
    inverse, gain = of_both * below, of_both * most * spread
    gain = gain if gain > inverse and pull >= ZERO else inverse
    return gain if gain < most_color * inverse else most_color * inverse
