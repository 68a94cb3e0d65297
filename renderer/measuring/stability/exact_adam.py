"""Adam (Kingma & Ba 2015, section 2, the order with folded corrections) in float64, a number at a time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BETA_1, BETA_2, EPSILON = 0.9, 0.999, 1e-15


def moved(
    values: FloatArray,
    by: FloatArray,
    moments: tuple[FloatArray, FloatArray],
    rate: float | FloatArray,
    steps: int,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Values and both moments after the `steps`-th update, from 1."""
    first = BETA_1 * moments[0] + (1 - BETA_1) * by
    second = BETA_2 * moments[1] + (1 - BETA_2) * by * by
    corrected = rate * np.sqrt(1 - BETA_2**steps) / (1 - BETA_1**steps)
    return values - corrected * first / (np.sqrt(second) + EPSILON), first, second
