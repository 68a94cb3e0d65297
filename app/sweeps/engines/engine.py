"""What a sweep knows of the place where its jobs run."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass


@dataclass(frozen=True, eq=False)
class Engine:
    """An executor that is open, and how it likes its jobs."""

    name: str
    executor: Executor
    workers: int
    """That run jobs at once, for the time left."""
    window: int
    """Jobs that are handed over at a time."""
