"""Frames that stand for all: the one rule, so that the window and the commands take the same ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

One = TypeVar("One")


def evenly(first: int, last: int, count: int) -> list[int]:
    """Numbers of `count` frames or fewer, evenly spread, from the first to the last, which both are among
    them where there are two."""
    places = np.linspace(first, last, min(last + 1 - first, count)).round()
    return [int(place) for place in places]


def some_of(every: Sequence[One], count: int) -> list[One]:
    """`count` of them or fewer, in the same way."""
    return [every[place] for place in evenly(0, len(every) - 1, count)]
