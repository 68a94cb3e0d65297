"""Density of blood of the preset `vessel`, on a grid of 2 x 2 pixels: a vessel of two pixels shows there."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import cv2
import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance import morphology
from enhance.field import Spans
from enhance.image import Float32Image
from enhance.part import part
from enhance.pixel_block import ONE, TWO, ZERO
from enhance.powers import LN_2, LOG2_E, brief_exp2, brief_log2
from enhance.redness import GREY, Bounds
from enhance.reflections import COLORLESS, without_reflections
from enhance.upscale import at_places, bring_up
from enhance.vessel_curves import faded
from enhance.vessel_first_pass import FLOOR, SUBSAMPLE
from enhance.wide_vectors import wide_vectors

BOUND = np.float32(0.5)
"""On the density that is found, a natural logarithm: at strength 1, green falls to 61 % at most."""
KNEE = np.float32(0.1)
"""Natural logarithm beyond the image's median up to which little counts."""
LEAST_WEIGHT: Final = 0.05
"""Of a place without colour, where one of colour has 1 more."""
SAMPLES: Final = 1 << 12
"""Places, or up to twice as many, whose median is taken."""
STRIP: Final = 32
"""Rows of one task."""
LEAST_SQUARE = np.float32(1e-12)


class Spared(NamedTuple):
    """How much of the density is left out of what is grey."""

    share: float
    """Of what is wholly so."""
    grey: Bounds


NOTHING: Final = Spared(0.0, GREY)


def background(absorbed: Float32Image, value: Float32Image, radius: int) -> Float32Image:
    """(h', w') of what is absorbed (h, w), without what is narrower than twice `radius` pixels.

    `value` is V on the same grid, which tells reflections; the result is in blocks of `step_of` the radius.
    """
    step = morphology.step_of(radius)
    blocks = _shrunk(absorbed, step // SUBSAMPLE)
    return morphology.opened(without_reflections(blocks, value, radius // step), radius // step)


def middle_density(
    absorbed: Float32Image, opened: Float32Image, radius: int, spans: Spans, keep: NDArray[np.uint8]
) -> float:
    """Median within the spans of an image's rows (all, where there are none), at evenly spread places: those
    where `keep` (H, W; empty: all) is not 0, or all where it keeps none."""
    grid = morphology.step_of(radius) // SUBSAMPLE
    apart = _apart(absorbed)
    y, x = np.arange(0, absorbed.shape[0], apart), np.arange(0, absorbed.shape[1], apart)
    density = np.maximum(absorbed[::apart, ::apart] - at_places(opened, y, x, grid), 0)
    density = density[_counted(density.shape, apart, spans, keep)]
    if density.size == 0:
        return 0.0
    # As np.median, in a fraction of its time.
    middle = [(density.size - 1) // 2, density.size // 2]
    return float(np.partition(density, middle)[middle].mean())


def middle_absorbed(
    absorbed: Float32Image, value: Float32Image, shading: float, spans: Spans, keep: NDArray[np.uint8]
) -> float:
    """Median of what is absorbed at the places of `middle_density`, with little weight on those without
    colour: what tissue is compared with hardly changes as a tool comes in.

    `value` is V on the same grid, of which `absorbed` has `shading` times the logarithm where red is largest.
    """
    apart = _apart(absorbed)
    seen, lit = absorbed[::apart, ::apart], value[::apart, ::apart]
    counted = _counted(seen.shape, apart, spans, keep)
    found = seen[counted]
    if found.size == 0:
        return 0.0
    low, high = COLORLESS
    color = found + np.float32(1 - shading) * np.log(lit[counted] + FLOOR)
    weights = LEAST_WEIGHT + np.clip((color - low) / (high - low), 0, 1, dtype=np.float64)
    order = np.argsort(found)
    below = np.cumsum(weights[order])
    return float(found[order[np.searchsorted(below, below[-1] / 2)]])


def blood_density(
    absorbed: Float32Image,
    value: Float32Image,
    opened: Float32Image,
    radius: int,
    noise: float,
    contrast: float = 0.0,
    middle: float = 0.0,
    shading: float = 0.0,
    spared: Spared = NOTHING,
) -> Float32Image:
    """(h, w) in [0, BOUND]: what stands out from the background, hardly so what is weaker than the noise.

    It fades where V on the same grid is dark, beside bright letters too; what is grey is left out by
    `spared`, where `shading` is that of `absorbed`. To it comes what is absorbed beyond `middle`, however
    wide, x: `contrast` x^2 / (x^2 + x + KNEE). Of each place alone, it makes no halo.
    """
    density, grid = np.empty_like(absorbed), morphology.step_of(radius) // SUBSAMPLE
    of_all = np.float32(contrast), np.float32(middle), np.float32(shading), np.float32(spared.share)
    low, high = np.float32(spared.grey[0]), np.float32(spared.grey[1])
    _stand_out(absorbed, value, opened[None], grid, np.float32(noise), *of_all, low, high, density)
    return density


def _apart(absorbed: Float32Image) -> int:
    """Of the places whose median is taken."""
    return max(3, math.isqrt(absorbed.size // SAMPLES))


def _counted(shape: tuple[int, ...], apart: int, spans: Spans, keep: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Of places so far apart, those that count; see `middle_density`."""
    y, x = (apart * np.arange(count) for count in shape)
    counts = np.ones(shape, bool)
    if len(spans):
        within = spans[SUBSAMPLE * y]
        counts = (SUBSAMPLE * x >= within[:, :1]) & (SUBSAMPLE * x < within[:, 1:])
    if len(keep):
        kept = counts & (keep[:: SUBSAMPLE * apart, :: SUBSAMPLE * apart] > 0)
        counts = kept if kept.any() else counts
    return counts


def _shrunk(plane: Float32Image, side: int) -> Float32Image:
    """Means over blocks; what is last repeats at the edge."""
    if side == 1:
        return plane
    below, beside = -plane.shape[0] % side, -plane.shape[1] % side
    whole = cv2.copyMakeBorder(plane, 0, below, 0, beside, cv2.BORDER_REPLICATE) if below or beside else plane
    size = whole.shape[1] // side, whole.shape[0] // side
    return np.asarray(cv2.resize(whole, size, interpolation=cv2.INTER_AREA), np.float32)


@njit(parallel=True, nogil=True, cache=True, fastmath={"contract"}, error_model="numpy")
def _stand_out(
    absorbed: NDArray[np.float32],  # (h, w)
    value: NDArray[np.float32],  # (h, w)
    opened: NDArray[np.float32],  # (1, h / grid, w / grid) rounded up
    grid: int,
    noise: np.float32,
    contrast: np.float32,
    middle: np.float32,
    shading: np.float32,
    spared: np.float32,
    low: np.float32,
    high: np.float32,
    density: NDArray[np.float32],  # (h, w), out
) -> None:
    rows, columns = absorbed.shape
    for strip in prange((rows + STRIP - 1) // STRIP):
        lines = np.empty((2, 1, columns + grid), np.float32)
        held = np.full(2, -1)
        for y in range(strip * STRIP, min((strip + 1) * STRIP, rows)):
            weight = bring_up(opened, y, grid, lines, held)
            _core(absorbed[y], value[y], lines[0, 0], lines[1, 0], weight, noise, density[y])
            if spared > ZERO:
                _spare_grey(absorbed[y], value[y], ONE - shading, spared, low, high, density[y])
            if contrast > ZERO:
                _add_all(absorbed[y], contrast, middle, density[y])


@part(fastmath={"contract"})
def _core(
    absorbed: NDArray[np.float32],
    value: NDArray[np.float32],
    even: NDArray[np.float32],
    odd: NDArray[np.float32],
    weight: np.float32,
    noise: np.float32,
    density: NDArray[np.float32],
) -> None:
    """Top-hat, coring, and a soft bound by the hyperbolic tangent."""
    wide_vectors()
    for i in range(len(density)):
        found = absorbed[i] - (even[i] + weight * (odd[i] - even[i]))
        found = found if found > ZERO else ZERO
        square = found * found
        cored = found * square / (square + noise * noise + LEAST_SQUARE)
        grown = brief_exp2(TWO * LOG2_E / BOUND * cored)
        density[i] = faded(value[i]) * BOUND * (ONE - TWO / (grown + ONE))


@part(fastmath={"contract"})
def _add_all(
    absorbed: NDArray[np.float32], contrast: np.float32, middle: np.float32, density: NDArray[np.float32]
) -> None:
    """What is absorbed beyond the middle: it sets in without an edge, and does not turn shadows black."""
    wide_vectors()
    for i in range(len(density)):
        beyond = absorbed[i] - middle
        beyond = beyond if beyond > ZERO else ZERO
        square = beyond * beyond
        density[i] += contrast * square / (square + beyond + KNEE)


@part(fastmath={"contract"})
def _spare_grey(
    absorbed: NDArray[np.float32],
    value: NDArray[np.float32],
    rest: np.float32,
    spared: np.float32,
    low: np.float32,
    high: np.float32,
    density: NDArray[np.float32],
) -> None:
    """Less of it where red hardly exceeds green. V is red where that is largest: `rest` of its logarithm is
    what `absorbed` lacks of log red - log green."""
    wide_vectors()
    for i in range(len(density)):
        red = absorbed[i] + rest * LN_2 * brief_log2(value[i] + FLOOR)
        grey = (high - red) * (ONE / (high - low))
        grey = grey if grey > ZERO else ZERO
        grey = grey if grey < ONE else ONE
        density[i] *= ONE - spared * grey
