"""What a sweep knows of the place where its jobs run."""

from __future__ import annotations

import os
from concurrent.futures import Executor
from dataclasses import dataclass


def workers_for(threads: int) -> int:
    """As many as this machine has cores for so many threads each."""
    return max(1, (os.cpu_count() or 1) // threads)


@dataclass(frozen=True, eq=False)
class Engine:
    """An executor that is open, and how it likes its jobs."""

    name: str
    executor: Executor
    workers: int
    """That run jobs at once, for the time left."""
    window: int
    """Jobs that are handed over at a time."""
    shares_fate: bool = False
    """With one worker that ends, the jobs of all are lost."""
