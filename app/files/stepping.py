"""Work in steps, with a result at its end: each step reported in other words, or all of them run at once."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import closing
from typing import TypeVar

Done = TypeVar("Done")
Told = TypeVar("Told")
Result = TypeVar("Result")


def map_steps(
    work: Generator[Done, None, Result], told: Callable[[Done], Told]
) -> Generator[Told, None, Result]:
    """The same work and result; closed before its end, it closes the work."""
    with closing(work):
        while True:
            try:
                done = next(work)
            except StopIteration as end:
                result: Result = end.value
                return result
            yield told(done)


def run_to_end(work: Generator[object, None, Result]) -> Result:
    """Its result."""
    while True:
        try:
            next(work)
        except StopIteration as end:
            result: Result = end.value
            return result
