"""Work in steps, with a result at its end: each step reported in other words, or all of them run at once."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import TypeVar

Done = TypeVar("Done")
TrainingLog = TypeVar("TrainingLog")
Result = TypeVar("Result")


def map_steps(
    work: Generator[Done, None, Result], told: Callable[[Done], TrainingLog]
) -> Generator[TrainingLog, None, Result]:
    """The same work and result; closed before its end, it closes the work."""
    try:
        while True:
            try:
                done = next(work)
            except StopIteration as end:
                result: Result = end.value
                return result
            yield told(done)
    finally:
        work.close()


def run_to_end(work: Generator[object, None, Result]) -> Result:
    """Its result."""
    while True:
        try:
            next(work)
        except StopIteration as end:
            result: Result = end.value
            return result
