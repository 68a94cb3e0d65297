"""Frames that stand for all: the one rule, so that the window and the commands take the same ones."""

from __future__ import annotations

import numpy as np


def evenly(first: int, last: int, count: int) -> list[int]:
    """Numbers of `count` frames or fewer, evenly spread, from the first to the last, which both are among
    them where there are two."""
    places = np.linspace(first, last, min(last + 1 - first, count)).round()
    return [int(place) for place in places]
