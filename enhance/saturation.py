"""Saturation (Eqs 11 and 12), and back to colours without ever computing a hue."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from enhance.image import Float32Image

MOST_PULL: Final = 1e30
"""Stands for an infinite `pull`; times the square of any grey level it is still a float32."""
FAINT, CLEAR = 8.0, 32.0
"""Chroma over its noise at which saturation is left alone, and from which on the bound is MOST_GAIN."""
MOST_GAIN: Final = 3.0
"""Of a small difference in S at the mean of S; Eqs 11 and 12 give 2 at S = 0.5 and no bound at 0 and 1."""


def pull(mean: float, d_factor: float) -> float:
    """k B / A of Eq 11, so that S* = S^2 / (S^2 + pull (1 - S)^2), see `stretch`; -1 for k = 0: S stays."""
    if d_factor == 0:
        return -1.0
    a = (1 - mean) ** 2 * (1 + 2 * mean)
    b = d_factor * mean**2 * (3 - 2 * mean)
    return b / a if b < MOST_PULL * a else MOST_PULL


def gain_at_mean(mean: float) -> float:
    """dS*/dS of Eqs 11 and 12 at S = S_m: how much chroma noise grows there; infinite at 0 and 1."""
    if not 0 < mean < 1 or mean**2 == 0:
        return math.inf
    of_white = pull(mean, 1.0) * (1 - mean) ** 2
    stretched = mean**2 / (mean**2 + of_white)
    return 2 * stretched * (1 - stretched) / (mean * (1 - mean))


def color_share(mean: float, chroma_snr: float | None) -> float:
    """The share w in S + w (S* - S), in [0, 1], by which the gain at the mean of S stays below its bound.

    The bound rises from 1 at a chroma-to-noise ratio of FAINT to MOST_GAIN at CLEAR; None: no noise is known.
    """
    clear = 1.0 if chroma_snr is None else (chroma_snr - FAINT) / (CLEAR - FAINT)
    most = 1 + (MOST_GAIN - 1) * min(max(clear, 0.0), 1.0)
    return min(1.0, (most - 1) / max(gain_at_mean(mean) - 1, 1e-9))


@dataclass(frozen=True, eq=False)
class Saturation:
    """S of HSV and its complement, each to full relative precision; both (H, W) in [0, 1]."""

    chroma: Float32Image
    """S = (max - min) / max of R, G, B; 0 at black."""
    white: Float32Image
    """1 - S = min / max; 1 at black."""


def saturation(colors: Float32Image, value: Float32Image) -> Saturation:
    """S of an (H, W, 3) image with V `value`."""
    low = colors.min(axis=2)
    lit = value > 0
    return Saturation(
        chroma=np.divide(value - low, value, out=np.zeros_like(value), where=lit),
        white=np.divide(low, value, out=np.ones_like(value), where=lit),
    )


def stretch(saturation: Saturation, mean: float, d_factor: float) -> Float32Image:
    """S* of Eqs 11 and 12, (H, W) in [0, 1].

    With k = d_factor and m = mean, d = B / A where A = (1 - m)^2 (1 + 2 m) and B = m^2 (3 - 2 m), so that
    S* = A S^2 / (A S^2 + k B (1 - S)^2): no pole at m = 1 or S = 0. What remains of 0/0 (no colour at S = 0,
    full colour at S = 1) is a fixed point, S* = S. k = 0 means that the stage is off, S* = S everywhere: the
    limit of the formula would be full saturation.

    Args:
        mean: S_m of Eq 12, in [0, 1].
        d_factor: k >= 0; the pivot S* = S lies at k d / (1 + k d), so smaller means more colour.
    """
    chroma, white = saturation.chroma, saturation.white
    if d_factor == 0:
        return chroma
    a = (1 - mean) ** 2 * (1 + 2 * mean)
    b = mean**2 * (3 - 2 * mean)
    colored = np.float32(a) * chroma * chroma
    total = colored + np.float32(d_factor * b) * white * white
    return np.asarray(np.divide(colored, total, out=chroma.copy(), where=total > 0))


def recolor(
    colors: Float32Image,
    value: Float32Image,
    saturation: Saturation,
    new_value: Float32Image,
    new_saturation: Float32Image,
) -> Float32Image:
    """The (H, W, 3) image with the hue of `colors`, V = `new_value` and S = `new_saturation`.

    With M and D the largest and the spread of a pixel's channels, c becomes V* (1 - S* (M - c) / D): what
    HSV to RGB gives for the same hue. Grey stays exactly grey.
    """
    chroma = saturation.chroma
    gain = np.divide(new_saturation, chroma, out=np.zeros_like(chroma), where=chroma > 0)
    lit = value[..., None] > 0
    below = np.divide(value[..., None] - colors, value[..., None], out=np.zeros_like(colors), where=lit)
    return np.asarray(new_value[..., None] * (1 - gain[..., None] * below))
