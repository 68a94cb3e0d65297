"""What an image does not need, with a bound on the error of leaving it out, in grey levels of the result.

Local detail turns Vn into the mean over scales of Vn^E (Eqs 8, 10). Leaving a scale out puts Vn in its place.
With |log2 E| <= t anywhere in the image, that changes V* by at most

    g(t) / n,   g(t) = max over x in [0, 1] of x - x^(2^t),

whatever Vn is. A colour is V* times a factor in [0, 1] (Eq 11), and `keep_black` takes it back in part:
neither makes an error larger. log2 E is P times the logarithm of the ratio of Eq 7, whose largest size over
the image, its reach, does not depend on P, z or the d-factor: it holds for all positions of these sliders.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.detail import FLOOR
from enhance.guided_filter import Window
from enhance.params import EnhanceParams
from enhance.part import part
from enhance.pixel_block import BLOCK, ONE, ZERO
from enhance.result import Omission
from enhance.statistics import Statistics

FLOAT_FLOOR = np.float32(FLOOR)
SPARSE = 8
"""Rows that tell of most scales that they cannot be left out."""
ROUNDING = 1e-4
"""Added to a reach: the float32 filter may differ by so much from the exact one that the bound is of."""


def decide(
    params: EnhanceParams, used: Statistics, grey: bool, reaches: tuple[float, ...]
) -> tuple[tuple[bool, ...], tuple[Omission, ...]]:
    """Which scales to leave out, and all that is left out with its bound.

    Args:
        params: `omit_below` is what all omitted scales together may change.
        used: z and P of the image.
        grey: the image has no colours.
        reaches: bounds on |log2| of Eq 7's ratio, one a scale.
    """
    omitted = [Omission("brightness", "z is 1", 0.0)] if used.z == 1 else []
    if grey:
        omitted.append(Omission("saturation", "the image is grey", 0.0))
    elif params.strength == 0:
        omitted.append(Omission("saturation", "strength is 0", 0.0))
    elif params.d_factor == 0:
        omitted.append(Omission("saturation", "d_factor is 0", 0.0))
    elif used.color == 0:
        omitted.append(Omission("saturation", "colours are no clearer than their noise", 0.0))
    bounds = [scale_bound(p, reach, len(used.p)) for p, reach in zip(used.p, reaches, strict=True)]
    chosen = left_out(bounds, params.omit_below)
    if all(chosen):
        omitted.append(Omission("local detail", "it changes almost nothing here", sum(bounds)))
        return chosen, tuple(omitted)
    for radius, bound, is_out in zip(params.radii, bounds, chosen, strict=True):
        if is_out:
            omitted.append(Omission(f"scale of {radius} px", "it changes almost nothing here", bound))
    return chosen, tuple(omitted)


def left_out(bounds: Sequence[float], limit: float) -> tuple[bool, ...]:
    """The scales, least effect first, whose bounds together stay below `limit` grey levels or are 0."""
    chosen, total = [False] * len(bounds), 0.0
    for index in sorted(range(len(bounds)), key=bounds.__getitem__):
        total += bounds[index]
        chosen[index] = total < limit or total == 0
    return tuple(chosen)


def scale_bound(p: float, reach: float, scales: int) -> float:
    """g(P reach) / n in grey levels: what one of n scales can change of V*."""
    u = p * reach * math.log(2) if p > 0 else 0.0
    if u == 0:
        return 0.0
    if u > 700:
        return 255.0 / scales
    at = math.exp(-u / math.expm1(u))
    return 255 * at * -math.expm1(-u) / scales


def range_reach(darkest: float, brightest: float) -> float:
    """Reach of every scale from the range of V alone: Q, a mean of values in the range, lies in it."""
    return math.log2((brightest + FLOOR) / (darkest + FLOOR))


def local_reach(low: NDArray[np.float32], window: Window, models: NDArray[np.float32]) -> float:
    """True bound on |log2 ratio| of a scale.

    The ratio of a pixel is a mean, with bilinear weights, of (a V + b + e) / (V + e) for the models around
    it, and that is monotone in V. So the ends of the range that V has around each model bound it. Of n values
    none is further from their mean than sqrt(n - 1) deviations (Samuelson, J. Am. Stat. Assoc. 63, 1968): the
    range follows from what the filter is made of, without another look at the image.

    Args:
        low: (2, h, w) mean and variance of V in each block of the fine grid.
        models: (2, h, w) of `WindowModels` on the window's grid.
    """
    _, rows, columns = models.shape
    most = np.ones((-(-rows // BLOCK), 2, columns), np.float32)
    _all_ratios(low, *_ranging(window), models, most)
    return math.log2(float(most.max())) + ROUNDING


def sparse_reach(low: NDArray[np.float32], window: Window, models: NDArray[np.float32]) -> float:
    """What a few rows tell of `local_reach`, which is no less: enough for most scales, and quickly had."""
    _, rows, columns = models.shape
    most = np.ones((2, columns), np.float32)
    _ratios(low, *_ranging(window), models, 0, rows, max(1, rows // SPARSE), most)
    return math.log2(float(most.max())) + ROUNDING


def _ranging(window: Window) -> tuple[int, np.float32]:
    """Pixels of the fine grid along a side of one of the window's; deviations that a value can be apart."""
    return 2 if window.coarse else 1, np.float32(math.sqrt(window.subsample**2 - 1))


@njit(parallel=True, nogil=True, cache=True, error_model="numpy")
def _all_ratios(
    low: NDArray[np.float32],  # (2, h, w)
    step: int,
    deviations: np.float32,
    models: NDArray[np.float32],  # (2, h / step, w / step), rounded up
    most: NDArray[np.float32],  # (n / BLOCK, 2, w / step), in and out: as of _ratios, of so many rows each
) -> None:
    for task in prange(len(most)):
        last = min((task + 1) * BLOCK, models.shape[1])
        _ratios(low, step, deviations, models, task * BLOCK, last, 1, most[task])


@njit(cache=True, fastmath={"contract"}, error_model="numpy")
def _ratios(
    low: NDArray[np.float32],
    step: int,
    deviations: np.float32,
    models: NDArray[np.float32],
    first: int,
    last: int,
    every: int,
    most: NDArray[np.float32],  # (2, w / step), in and out: the largest ratio and 1 / ratio of each column
) -> None:
    columns = models.shape[2]
    for y in range(first, last, every):
        # Nothing on either side of the first block and the last.
        darkest = np.full((columns + 2) * step, ONE)
        brightest = np.full((columns + 2) * step, ZERO)
        for row in range(max((y - 1) * step, 0), min((y + 2) * step, low.shape[1])):
            _widen_range(low, row, deviations, darkest[step:], brightest[step:])
        if step == 2:
            for x in range(columns + 2):
                left, right = np.uint64(2 * x), np.uint64(2 * x + 1)
                darkest[x] = darkest[left] if darkest[left] < darkest[right] else darkest[right]
                brightest[x] = brightest[left] if brightest[left] > brightest[right] else brightest[right]
        _take_ratios(models, y, darkest, brightest, most)


@part(fastmath={"contract"})
def _widen_range(
    low: NDArray[np.float32],
    row: int,
    deviations: np.float32,
    darkest: NDArray[np.float32],
    brightest: NDArray[np.float32],
) -> None:
    """Take in what the blocks of a row can hold."""
    mean, variance = low[0, row], low[1, row]
    for x in range(len(mean)):
        apart = deviations * np.sqrt(variance[x])
        dark, bright = mean[x] - apart, mean[x] + apart
        dark = dark if dark > ZERO else ZERO
        bright = bright if bright < ONE else ONE
        darkest[x] = dark if dark < darkest[x] else darkest[x]
        brightest[x] = bright if bright > brightest[x] else brightest[x]


@part(fastmath={"contract"})
def _take_ratios(
    models: NDArray[np.float32],
    y: int,
    darkest: NDArray[np.float32],
    brightest: NDArray[np.float32],
    most: NDArray[np.float32],
) -> None:
    """The largest ratio and 1 / ratio of each model, for V as in its own block and the one on either side."""
    a, b, highest, inverse = models[0, y], models[1, y], most[0], most[1]
    dark_here, dark_after = darkest[1:], darkest[2:]
    bright_here, bright_after = brightest[1:], brightest[2:]
    for x in range(len(a)):
        dark, bright = darkest[x], brightest[x]
        dark = dark_here[x] if dark_here[x] < dark else dark
        dark = dark_after[x] if dark_after[x] < dark else dark
        bright = bright_here[x] if bright_here[x] > bright else bright
        bright = bright_after[x] if bright_after[x] > bright else bright
        first = (a[x] * dark + b[x] + FLOAT_FLOOR) / (dark + FLOAT_FLOOR)
        last = (a[x] * bright + b[x] + FLOAT_FLOOR) / (bright + FLOAT_FLOOR)
        high, low = (first, last) if first > last else (last, first)
        highest[x] = high if high > highest[x] else highest[x]
        inverse[x] = ONE / low if ONE / low > inverse[x] else inverse[x]
