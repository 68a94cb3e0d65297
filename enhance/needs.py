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
from typing import Any

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.detail import FLOOR
from enhance.image import Float32Image
from enhance.params import EnhanceParams
from enhance.result import Omission
from enhance.statistics import Statistics
from enhance.survey import extremes

SAMPLES = 40
"""Rows and columns of the sparse grid that tells when no scale can be left out."""
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
    elif params.d_factor == 0:
        omitted.append(Omission("saturation", "d_factor is 0", 0.0))
    chosen = left_out(used.p, reaches, params.omit_below)
    bounds = [scale_bound(p, reach, len(used.p)) for p, reach in zip(used.p, reaches, strict=True)]
    if all(chosen):
        omitted.append(Omission("local detail", "it changes next to nothing here", sum(bounds)))
        return chosen, tuple(omitted)
    for radius, bound, is_out in zip(params.radii, bounds, chosen, strict=True):
        if is_out:
            omitted.append(Omission(f"scale of {radius} px", "it changes next to nothing here", bound))
    return chosen, tuple(omitted)


def left_out(p: tuple[float, ...], reaches: tuple[float, ...], limit: float) -> tuple[bool, ...]:
    """The scales, least effect first, whose bounds together stay below `limit` grey levels or are 0."""
    bounds = [scale_bound(one, reach, len(p)) for one, reach in zip(p, reaches, strict=True)]
    chosen, total = [False] * len(p), 0.0
    for index in sorted(range(len(p)), key=bounds.__getitem__):
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


def sampled_reaches(low: Float32Image, models: NDArray[np.float32]) -> tuple[float, ...]:
    """|log2 ratio| on a sparse grid of low-resolution pixels: some pixels reach about this far."""
    rows, columns = (max(1, size // SAMPLES) for size in low.shape)
    value = low[::rows, ::columns]
    a, b = models[:, 0, ::rows, ::columns], models[:, 1, ::rows, ::columns]
    ratio = (a * value + b + np.float32(FLOOR)) / (value + np.float32(FLOOR))
    return tuple(float(reach) for reach in np.abs(np.log2(ratio)).max(axis=(1, 2)))


def local_reaches(
    image: NDArray[Any], full: float, subsample: int, models: NDArray[np.float32]
) -> tuple[float, ...]:
    """True bound on |log2 ratio| of each scale.

    The ratio of a pixel is a mean, with bilinear weights, of (a V + b + e) / (V + e) for the models around
    it, and that is monotone in V. So the ends of the range that V has around each model bound it.

    Args:
        image: (H, W, 3).
        full: the image's value of 1.0.
        models: (n, 2, h, w) of `window_models`.
    """
    scales, _, rows, columns = models.shape
    darkest, brightest = np.empty((rows, columns), np.float32), np.empty((rows, columns), np.float32)
    extremes(image, np.float32(full), subsample, darkest, brightest)
    reaches = np.empty((rows, scales), np.float32)
    _reaches(models, darkest, brightest, np.float32(FLOOR), reaches)
    return tuple(math.log2(float(reach)) + ROUNDING for reach in reaches.max(axis=0))


@njit(parallel=True, cache=True, error_model="numpy")
def _reaches(
    models: NDArray[np.float32],  # (n, 2, h, w)
    darkest: NDArray[np.float32],  # (h, w), smallest V of each block
    brightest: NDArray[np.float32],  # (h, w), largest
    floor: np.float32,
    out: NDArray[np.float32],  # (h, n), out: of each row, the largest of ratio and 1 / ratio
) -> None:
    rows, columns = darkest.shape
    for y in prange(rows):
        least = _least_around(darkest, y, np.float32(1.0))
        most = _least_around(brightest, y, np.float32(-1.0))
        high, low = np.empty(columns, np.float32), np.empty(columns, np.float32)
        for scale in range(models.shape[0]):
            a, b = models[scale, 0, y], models[scale, 1, y]
            for x in range(columns):
                first = (a[x] * least[x] + b[x] + floor) / (least[x] + floor)
                last = (a[x] * most[x] + b[x] + floor) / (most[x] + floor)
                high[x] = max(first, last)
                low[x] = min(first, last)
            out[y, scale] = max(high.max(), np.float32(1.0) / low.min())


@njit(error_model="numpy")
def _least_around(image: NDArray[np.float32], y: int, sign: np.float32) -> NDArray[np.float32]:
    """(w,) the smallest of the 3 x 3 pixels around each pixel of row y; the largest for a sign of -1."""
    rows, columns = image.shape
    above, here, below = image[max(y - 1, 0)], image[y], image[min(y + 1, rows - 1)]
    padded = np.empty(columns + 2, np.float32)
    for x in range(columns):
        padded[x + 1] = min(sign * above[x], min(sign * here[x], sign * below[x]))
    padded[0], padded[columns + 1] = padded[1], padded[columns]
    out = np.empty(columns, np.float32)
    for x in range(columns):
        out[x] = sign * min(padded[x], min(padded[x + 1], padded[x + 2]))
    return out
