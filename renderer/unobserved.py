"""How it looks where nothing was observed: grey, and diagonal lines, which no tissue looks like."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Rgb = tuple[float, float, float]
BLACK: Final[Rgb] = (0.0, 0.0, 0.0)
GREY: Final[Rgb] = (0.25, 0.25, 0.25)
LINES: Final[Rgb] = (0.4, 0.4, 0.4)
PERIOD: Final = 8
WIDTH: Final = 2
"""Pixels along a row: from a line to the next, and of a line."""


def line_mask(height: int, width: int) -> NDArray[np.bool_]:
    """(H, W), True on the lines, which rise to the right; the first pixel of the top row is on one."""
    return (np.arange(height)[:, None] + np.arange(width)) % PERIOD < WIDTH
