"""Work in steps: each reported in other words, all of them run at once for the result, or made in advance."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from itertools import islice
from typing import TypeVar

Done = TypeVar("Done")
Told = TypeVar("Told")
Result = TypeVar("Result")
DEPTH = 3
"""Items that wait: enough to even out, few enough for large frames."""


def map_steps(
    work: Generator[Done, None, Result], told: Callable[[Done], Told]
) -> Generator[Told, None, Result]:
    """The same work and result, with `told` of each step; closed before its end, it closes the work."""
    with closing(work):
        while True:
            try:
                done = next(work)
            except StopIteration as end:
                result: Result = end.value
                return result
            yield told(done)


def run_to_end(work: Generator[object, None, Result]) -> Result:
    """Take all steps of the work and return its result."""
    while True:
        try:
            next(work)
        except StopIteration as end:
            result: Result = end.value
            return result


def ahead(items: Generator[Done, None, None]) -> Generator[Done, None, None]:
    """The same items in the same order, all but the first made by a thread of their own up to DEPTH in
    advance, so that reading, enhancing and writing a video overlap.

    What `items` raises is raised here, after the items before it. `items` is closed when it ends and when
    this generator is closed early.
    """

    def one() -> tuple[Done, ...]:
        return tuple(islice(items, 1))

    with closing(items):
        # In this thread: it may wait minutes for kernels to compile, which Ctrl+C ends in the main one alone.
        item = one()
        thread = ThreadPoolExecutor(1)
        try:
            waiting = deque(thread.submit(one) for _ in range(DEPTH))
            while item:
                yield item[0]
                item = waiting.popleft().result()
                waiting.append(thread.submit(one))
        finally:
            # Waits for the item that is being made; `items` cannot be closed before.
            thread.shutdown(cancel_futures=True)
