"""A few frames that stand for all of a clip."""

from __future__ import annotations

import numpy as np


def spread(count: int, most: int) -> tuple[int, ...]:
    """Of the numbers below `count` at most so many, evenly apart: the first, the last and some between."""
    return tuple(dict.fromkeys(np.linspace(0, count - 1, most).astype(int).tolist()))
