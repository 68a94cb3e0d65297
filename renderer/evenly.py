"""A few frames that stand for all of a clip: chosen here, so that all who look take the same ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from renderer.camera import FloatArray

T = TypeVar("T")


def evenly(items: Sequence[T], count: int) -> list[T]:
    """`count` of the items or fewer, evenly spread, the first and the last among them where there are two."""
    return [items[int(place)] for place in _places(items, count).round()]


def evenly_floored(items: Sequence[T], count: int) -> list[T]:
    """The same, but where an even place lies between two items, the former, even if the latter is nearer.

    By these, readers measure what then holds for all frames, such as how many rows are text, or by how much
    right images are moved: by others, clips of former runs would be read a little otherwise.
    """
    return [items[int(place)] for place in _places(items, count)]


def _places(items: Sequence[T], count: int) -> FloatArray:
    return np.linspace(0, len(items) - 1, min(len(items), count))
