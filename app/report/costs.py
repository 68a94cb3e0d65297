"""Memory as the report states it."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable

import numpy as np


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
