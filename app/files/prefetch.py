"""Work done in advance by a thread, so that reading, enhancing and writing a video overlap."""

from __future__ import annotations

import queue
import threading
from collections.abc import Generator
from typing import TypeVar

T = TypeVar("T")

DEPTH = 3
"""Items that wait: enough to even out, few enough for large frames."""


def ahead(items: Generator[T, None, None], depth: int = DEPTH) -> Generator[T, None, None]:
    """The same items in the same order, made by a thread of their own up to `depth` in advance.

    What `items` raises is raised here, after the items before it. `items` is closed when it ends and when
    this generator is closed early.
    """
    waiting: queue.Queue[tuple[T] | BaseException | None] = queue.Queue(depth)
    stop = threading.Event()
    thread = threading.Thread(target=_produce, args=(items, waiting, stop), daemon=True)
    thread.start()
    try:
        while (item := waiting.get()) is not None:
            if isinstance(item, BaseException):
                raise item
            yield item[0]
    finally:
        stop.set()
        while thread.is_alive():
            _drop(waiting)
            thread.join(0.01)


def _produce(
    items: Generator[T, None, None],
    waiting: queue.Queue[tuple[T] | BaseException | None],
    stop: threading.Event,
) -> None:
    try:
        for item in items:
            waiting.put((item,))
            if stop.is_set():
                break
        waiting.put(None)
    except BaseException as error:
        waiting.put(error)
    finally:
        items.close()


def _drop(waiting: queue.Queue[tuple[T] | BaseException | None]) -> None:
    """Makes room for a producer that waits to put its item."""
    try:
        while True:
            waiting.get_nowait()
    except queue.Empty:
        return
