"""Run times as the report states them: medians with their spread, of works that take turns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np


@dataclass(frozen=True)
class Laps:
    """Seconds."""

    median: float
    spread: float
    """Half of the distance between the quartiles."""


def laps(works: Sequence[Callable[[], object]], repeats: int) -> list[Laps]:
    """Of each work, after one lap that does not count; they take turns, so that load slows them alike."""
    taken = np.empty((repeats + 1, len(works)))
    for row in taken:
        for index, work in enumerate(works):
            start = perf_counter()
            work()
            row[index] = perf_counter() - start
    low, middle, high = np.percentile(taken[1:], (25, 50, 75), axis=0)
    return [Laps(float(m), float((h - l) / 2)) for l, m, h in zip(low, middle, high, strict=True)]  # noqa: E741
