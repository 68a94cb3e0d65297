"""Run times of works that take turns, so that other load slows them alike."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Laps:
    """Seconds: their median with its spread."""

    median: float
    spread: float
    """Half of the distance between the quartiles."""

    @classmethod
    def of(cls, seconds: NDArray[np.float64]) -> Laps:
        """Of any shape."""
        low, middle, high = np.percentile(seconds, (25, 50, 75)).tolist()
        return cls(middle, (high - low) / 2)


def laps(works: Sequence[Callable[[], object]], repeats: int) -> list[Laps]:
    """Of each work; see `interleaved_times`."""
    return [Laps.of(times) for times in interleaved_times(works, repeats)]


def interleaved_times(works: Sequence[Callable[[], object]], repeats: int) -> NDArray[np.float64]:
    """(works, repeats) seconds, after one lap that does not count."""
    taken = np.empty((repeats + 1, len(works)))
    for row in taken:
        for place, work in enumerate(works):
            began = perf_counter()
            work()
            row[place] = perf_counter() - began
    return np.ascontiguousarray(taken[1:].T)
