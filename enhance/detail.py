"""Local detail (Eqs 7-10): darker than its surround gets darker, brighter gets brighter."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from enhance.image import Float32Image
from enhance.params import PForm

FLOOR: Final = 1 / 255
"""Added to Q and to V: a ratio of blacks is 1. A floor under V alone turns black white."""


def exponent(sigma: float, form: PForm) -> float:
    """P of Eq 9.

    Args:
        sigma: standard deviation of Q in grey levels, 0 to 127.5.
        form: "literal" jumps by 0.02 at sigma = 2 and by 0.04 at 10, as printed; "continuous" follows the
            middle branch from 7/4 (at 2.125) to 1/2 (at 10.25).
    """
    middle = (27 - 2 * sigma) / 13
    if form == "continuous":
        return min(max(middle, 0.5), 1.75)
    if sigma <= 2:
        return 1.75
    return middle if sigma < 10 else 0.5


def surround_ratio(value: Float32Image, filtered: Float32Image, p: float) -> Float32Image:
    """E of Eq 7, ((Q + e) / (V + e))^P with e = 1/255; below 1 where a pixel is brighter than around it.

    The ratio is within [1/256, 256], so E is finite for all P.
    """
    e = np.float32(FLOOR)
    ratio = (filtered + e) / (value + e)
    return np.sqrt(ratio) if p == 0.5 else ratio ** np.float32(p)


def detailed(brightened: Float32Image, ratio: Float32Image) -> Float32Image:
    """v of Eq 8, Vn^E, in [0, 1]; 0 where it underflows."""
    return np.asarray(brightened**ratio, dtype=np.float32)


def mean_over_scales(details: Iterable[Float32Image]) -> Float32Image:
    """V* of Eq 10, scales weighted equally."""
    scales = list(details)
    return np.asarray(sum(scales[1:], scales[0]) / np.float32(len(scales)), dtype=np.float32)
