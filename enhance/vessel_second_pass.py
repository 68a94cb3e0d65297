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
    INVERSE,
    LEAST_COLOR,
    LOG,
    MOST,
    OFFSET,
    ONE,
    PLANES,
    RED,
    SLOPE,
    TOTAL,
    VALUE,
    ZERO,
    copy_pixels,
    keep_within,
    load_keep,
)
from enhance.powers import exp2, log2
from enhance.rows import REACH, ROWS, held_width, read_row
from enhance.second_pass import FLOOR, add_scale, faded_to_black, filter_row, store
from enhance.upscale import bring_up
from enhance.vessel_curves import unpacked, value_of
from enhance.vessel_first_pass import SUBSAMPLE, TASK, calm

ABSORPTION: Final = np.array([0.15, 1.0, 0.8], dtype=np.float32)
"""Of haemoglobin in the red, green and blue of a camera, relative to green (coarse: sensors differ)."""
TWENTY = np.float32(20.0)
BOUND = np.float32(0.5)
"""On the density that is found, a natural logarithm: at strength 1, green falls to 61 % at most."""
LOWEST, DIM, LIT = np.float32(vessel_curves.LOWEST), np.float32(vessel_curves.DIM), np.float32(0.4)
"""log2 V as of `vessel_curves`; V between which `gamma` and the layer fade in: dark vessels do not become
black."""
TWO, THREE = np.float32(2.0), np.float32(3.0)
TINY = np.float32(1e-6)
LEAST_SQUARE = np.float32(1e-12)
LOG2_E = np.float32(1 / np.log(2))
MOST_EXPONENT = np.float32(80.0)


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
    absorbed: NDArray[np.float32],  # (H, W) of the first pass
    opened: NDArray[np.float32],  # (1, h, w): its background, in blocks of `step`
    step: int,
    powers: NDArray[np.float32],  # of V^gamma by V
    pull: np.float32,  # k B / A of Eq 11; negative: S stays
    most_color: np.float32,  # bound on the gain of S
    strength: np.float32,
    noise: np.float32,  # density below which structures are hardly strengthened
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
        ground = np.zeros((2, 1, width + step), np.float32)
        held, held_ground = np.full((scales, 2), -1), np.full(2, -1)
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
            weight = bring_up(opened, y, step, ground, held_ground)
            sums[:] = ZERO
            for x0 in range(first // CHUNK * CHUNK, end if end > first else 0, CHUNK):
                count = min(CHUNK, columns - x0)
                calm(image[y, x0 : x0 + count], across, y, x0, unit, apart, narrow, chunk)
                load_keep(keep, y, x0, count, chunk)
                if first > x0 or end < x0 + count:
                    keep_within(first, end, x0, chunk)
                _brighten(chunk, logarithms)
                for i in range(CHUNK):
                    chunk[TOTAL, i] = ZERO
                    chunk[INVERSE, i] = ONE / (chunk[VALUE, i] + FLOOR)
                for scale in range(scales):
                    filter_row(lines[scale], x0, weights[scale], chunk)
                    add_scale(chunk, exponents[scale], pivot, sums[scale])
                _deepen(chunk, powers, ONE / np.float32(scales))
                _color(chunk, pull, most_color)
                for i in range(count):
                    chunk[OFFSET, i] = absorbed[y, x0 + i]
                _find(chunk, ground[0, 0, x0:], ground[1, 0, x0:], weight, strength, noise)
                _attenuate(chunk, is_grey, full)
                store(chunk, full, apart, out[y, x0 : x0 + count])
            copy_pixels(image[y, :first], out[y, :first])
            copy_pixels(image[y, end:], out[y, end:])
            totals += sums
        for scale in range(scales):
            moments[task, scale, 0] = totals[scale, 0].sum()
            moments[task, scale, 1] = totals[scale, 1].sum()


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _faded(value: np.float32) -> np.float32:
    """Smoothstep of V between DIM and LIT."""
    t = (value - DIM) * (ONE / (LIT - DIM))
    t = t if t > ZERO else ZERO
    t = t if t < ONE else ONE
    return t * t * (THREE - TWO * t)


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _brighten(chunk: NDArray[np.float32], logarithms: NDArray[np.float32]) -> None:
    """log2 of Vn of Eq 1."""
    terms = unpacked(logarithms)
    for i in range(CHUNK):
        log = log2(chunk[VALUE, i])
        chunk[LOG, i] = value_of(terms, (log if log > LOWEST else LOWEST) * (-TWO / LOWEST) + ONE)


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _deepen(chunk: NDArray[np.float32], powers: NDArray[np.float32], share: np.float32) -> None:
    """V* of the sum over scales in TOTAL, black kept, and `gamma` where it is not dark; into TOTAL."""
    terms = unpacked(powers)
    for i in range(CHUNK):
        value = chunk[VALUE, i]
        bright = chunk[TOTAL, i] * share
        bright = value + faded_to_black(value) * (bright - value)
        bright = bright if bright < ONE else ONE
        deep = value_of(terms, (bright - DIM) * (TWO / (ONE - DIM)) - ONE)
        chunk[TOTAL, i] = bright + _faded(bright) * (deep - bright)


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _color(chunk: NDArray[np.float32], pull: np.float32, most_color: np.float32) -> None:
    """Colours of V in TOTAL, with the gain of S between 1 and its bound; the hue stays.

    With M and D the largest and the spread of a pixel's channels, S* / S = M D / (D^2 + pull m^2).
    """
    for i in range(CHUNK):
        most, least, value = chunk[MOST, i], chunk[LEAST_COLOR, i], chunk[TOTAL, i]
        spread = most - least
        spread = spread if spread > TINY * most else TINY * most
        below = spread * spread + pull * least * least
        below = below if below > LEAST_SQUARE * LEAST_SQUARE else LEAST_SQUARE * LEAST_SQUARE
        most_or_tiny = most if most > TINY else TINY
        of_both = ONE / (most_or_tiny * below)  # One division for two.
        inverse, gain = of_both * below, of_both * most_or_tiny * spread
        gain = gain if gain > inverse and pull >= ZERO else inverse
        gain = gain if gain < most_color * inverse else most_color * inverse
        fall = value * gain
        chunk[RED, i] = value - fall * (most - chunk[RED, i])
        chunk[GREEN, i] = value - fall * (most - chunk[GREEN, i])
        chunk[BLUE, i] = value - fall * (most - chunk[BLUE, i])


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _find(
    chunk: NDArray[np.float32],
    even: NDArray[np.float32],
    odd: NDArray[np.float32],
    weight: np.float32,
    strength: np.float32,
    noise: np.float32,
) -> None:
    """The density of blood times `strength`, into SLOPE: top-hat, coring, and a soft bound by the hyperbolic
    tangent."""
    for i in range(CHUNK):
        found = chunk[OFFSET, i] - (even[i] + weight * (odd[i] - even[i]))
        found = found if found > ZERO else ZERO
        square = found * found
        cored = found * square / (square + noise * noise + LEAST_SQUARE)
        grown = exp2(TWO * LOG2_E / BOUND * cored)
        chunk[SLOPE, i] = strength * _faded(chunk[VALUE, i]) * BOUND * (ONE - TWO / (grown + ONE))


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _attenuate(chunk: NDArray[np.float32], is_grey: bool, full: np.float32) -> None:
    """R, G and B less what the density takes, times the value that means 1.0.

    ABSORPTION in twentieths is whole, so powers of one exponential serve for three.
    """
    for i in range(CHUNK):
        power = exp2(-LOG2_E / TWENTY * chunk[SLOPE, i])
        second = power * power
        fourth = second * second
        eighth = fourth * fourth
        for_blue = eighth * eighth
        for_green = for_blue * fourth
        chunk[RED, i] *= (for_green if is_grey else second * power) * full
        chunk[GREEN, i] *= for_green * full
        chunk[BLUE, i] *= (for_green if is_grey else for_blue) * full
