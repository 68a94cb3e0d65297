"""Diagonal lines over what was not observed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

PERIOD = 8
WIDTH = 2
"""Pixels along a row: from a line to the next, and of a line."""


def line_mask(height: int, width: int) -> NDArray[np.bool_]:
    """(H, W), True on the lines, which rise to the right; the first pixel of the top row is on one."""
    return (np.arange(height)[:, None] + np.arange(width)) % PERIOD < WIDTH
