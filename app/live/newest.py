"""A place for one thing between two threads: a newer one takes the place of one that nobody has taken."""

from __future__ import annotations

import threading
from typing import Generic, TypeVar

Item = TypeVar("Item")


class Newest(Generic[Item]):
    """Holds the newest item; what is never taken is counted as dropped."""

    def __init__(self) -> None:
        self._ready = threading.Condition()
        self._item: Item | None = None
        self.dropped = 0

    def put(self, item: Item) -> None:
        with self._ready:
            self.dropped += self._item is not None
            self._item = item
            self._ready.notify()

    def take(self, seconds: float = 0.0) -> Item | None:
        """The newest, once; None where there is none and none comes within so many seconds."""
        with self._ready:
            if self._item is None and seconds > 0:
                self._ready.wait(seconds)
            item, self._item = self._item, None
            return item
