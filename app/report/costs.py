"""Run times and memory as the report states them."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from renderer.measuring.interleaved_timing import interleaved_times


@dataclass(frozen=True)
class Laps:
    """Seconds: their median with its spread."""

    median: float
    spread: float
    """Half of the distance between the quartiles."""


def laps(works: Sequence[Callable[[], object]], repeats: int) -> list[Laps]:
    """Of each work; they take turns, after one lap that does not count."""
    quartiles = np.percentile(interleaved_times(works, repeats), (25, 50, 75), axis=1).T.tolist()
    return [Laps(middle, (high - low) / 2) for low, middle, high in quartiles]


def held_megabytes(work: Callable[[], object]) -> float:
    """MB of the arrays that the work has made and that are still held after it, its result among them.

    The same for the same work; other objects than arrays are not counted.
    """
    tracemalloc.start()
    try:
        result = work()
        arrays = tracemalloc.DomainFilter(True, np.lib.tracemalloc_domain)
        traces = tracemalloc.take_snapshot().filter_traces([arrays]).traces
        del result
        return sum(trace.size for trace in traces) / 1e6
    finally:
        tracemalloc.stop()
