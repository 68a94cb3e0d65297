"""Work done in advance by a thread, so that reading, enhancing and writing a video overlap."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from itertools import islice
from typing import TypeVar

T = TypeVar("T")

DEPTH = 3
"""Items that wait: enough to even out, few enough for large frames."""


def ahead(items: Generator[T, None, None]) -> Generator[T, None, None]:
    """The same items in the same order, made by a thread of their own up to DEPTH in advance.

    What `items` raises is raised here, after the items before it. `items` is closed when it ends and when
    this generator is closed early.
    """

    def one() -> tuple[T, ...]:
        return tuple(islice(items, 1))

    with closing(items):
        thread = ThreadPoolExecutor(1)
        try:
            waiting = deque(thread.submit(one) for _ in range(DEPTH))
            while item := waiting.popleft().result():
                waiting.append(thread.submit(one))
                yield item[0]
        finally:
            # Waits for the item that is being made; `items` cannot be closed before.
            thread.shutdown(cancel_futures=True)
