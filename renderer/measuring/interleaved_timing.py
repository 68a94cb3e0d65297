"""Run times of works that take turns, so that other load slows them alike."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import perf_counter

import numpy as np
from numpy.typing import NDArray


def interleaved_times(works: Sequence[Callable[[], object]], repeats: int) -> NDArray[np.float64]:
    """(works, repeats) seconds, after one lap that does not count."""
    taken = np.empty((repeats + 1, len(works)))
    for row in taken:
        for place, work in enumerate(works):
            began = perf_counter()
            work()
            row[place] = perf_counter() - began
    return np.ascontiguousarray(taken[1:].T)
