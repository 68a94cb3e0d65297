"""Live sources of tests: frames of one grey level each, as fast or as seldom as a test wants."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from app.live.sources.source import Arrived, SourceLost
from renderer.clip import ByteImage

SIZE = (48, 64)


def painted(level: int, size: tuple[int, int] = SIZE) -> ByteImage:
    """(H, W, 3), reddish, a dark line across."""
    image = np.full((*size, 3), (level, level // 2, level // 3), np.uint8)
    image[size[0] // 2] //= 2
    return image


@dataclass
class PaintedSource:
    """Gives its frames one after another, each after `pause` seconds; then it waits, ends or is lost."""

    levels: Sequence[int]
    pause: float = 0.01
    then: str = "end"
    size: tuple[int, int] = SIZE
    told: str = "64 × 48"
    frames_per_second: float | None = 50.0
    closed: list[float] = field(default_factory=list)
    _given: int = 0

    def read(self) -> Arrived | None:
        time.sleep(self.pause)
        if self._given < len(self.levels):
            level, self._given = self.levels[self._given], self._given + 1
            at = time.perf_counter()
            return Arrived(lambda: painted(level, self.size), at, at)
        if self.then == "lose":
            raise SourceLost("unplugged")
        if self.then == "wait" and not self.closed:
            time.sleep(0.2)
            raise SourceLost("silent")
        return None

    def close(self) -> None:
        self.closed.append(time.perf_counter())


def wait_for(until: Callable[[], bool], what: str, seconds: float = 10.0) -> None:
    end = time.monotonic() + seconds
    while not until():
        assert time.monotonic() < end, f"waited {seconds} s for {what}"
        time.sleep(0.002)
