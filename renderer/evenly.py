"""A few that stand for all: the one rule, so that whoever looks takes the same ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

T = TypeVar("T")


def evenly(items: Sequence[T], count: int) -> list[T]:
    """`count` of the items or fewer, evenly spread, the first and the last among them where there are two."""
    places = np.linspace(0, len(items) - 1, min(len(items), count)).round()
    return [items[int(place)] for place in places]
