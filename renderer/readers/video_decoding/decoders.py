"""Which videos have a decoder: those that were read last."""

from __future__ import annotations

import threading
import weakref
from typing import Final, Protocol

MOST: Final = 4
"""A stereo pair, and one that it is compared with: a decoder of 1280x720 has 30 MB of frames, and threads."""


class Rests(Protocol):
    """A video that can do without its decoder until a frame is read."""

    def rest(self) -> bool:
        """Give it up; False where it is at work."""


class Decoders:
    """Of the videos that are open, at most `most` have one, but for those at work.

    Whoever keeps a video that is no longer looked at, to know it again, keeps its index alone.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._lock = threading.Lock()
        self._used: list[weakref.ref[Rests]] = []
        """The last read last."""

    def use(self, video: Rests) -> None:
        """It has one now, or will in a moment. Never waits for a video."""
        with self._lock:
            others = [other for kept in self._used if (other := kept()) is not None and other is not video]
            at_work = [other for other in others[: 1 - self._most] if not other.rest()]
            self._used = [weakref.ref(each) for each in (*at_work, *others[1 - self._most :], video)]


DECODERS: Final = Decoders(MOST)
"""Of this process."""
