"""Frames of a real clip with the time of their capture painted in: as a source, and for an encoder."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from app.live.sources.source import Arrived
from renderer.clip import ByteImage
from renderer.sources import open_clip
from tests.benchmarks.live_delay.time_code import paint

KEPT: Final = 24
"""Frames that are shown in turn, forth and back."""
Size = tuple[int, int]


class PaintedSource:
    """A source that takes a frame at each tick of its rate, as a camera without a delay of its own would."""

    def __init__(self, clip: Path, size: Size, frames_per_second: float) -> None:
        self.frames_per_second: float | None = frames_per_second
        self.told = f"{size[0]} × {size[1]}, {frames_per_second:.3g} frames/s, painted"
        self._images = _images(clip, size)
        self._interval = 1 / frames_per_second
        self._next = time.perf_counter()
        self._count = 0

    def read(self) -> Arrived:
        time.sleep(max(self._next - time.perf_counter(), 0.0))
        self._next += self._interval
        image, at = self._images[self._count % len(self._images)].copy(), time.perf_counter()
        self._count += 1
        paint(image, at)
        return Arrived(lambda: image, at, at)

    def close(self) -> None:
        """It holds nothing."""


def feed(clip: Path, size: Size, frames_per_second: float) -> None:
    """Write frames as raw RGB to the standard output, in real time, until nobody reads them."""
    source = PaintedSource(clip, size, frames_per_second)
    while True:
        sys.stdout.buffer.write(source.read().read().tobytes())
        sys.stdout.buffer.flush()


def _images(clip: Path, size: Size) -> list[ByteImage]:
    opened = open_clip(clip)
    taken = [opened.read_image(index) for index in range(min(KEPT, len(opened)))]
    forth = [np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8) for image in taken]
    return forth + forth[-2:0:-1]


if __name__ == "__main__":
    given = sys.argv[1:]
    feed(Path(given[0]), (int(given[1]), int(given[2])), float(given[3]))
