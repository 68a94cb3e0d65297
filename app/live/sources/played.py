"""A file or a folder of images played as if it were live: each frame arrives at its own time."""

from __future__ import annotations

import time
from bisect import bisect_right
from functools import partial
from pathlib import Path

from app.live.sources.source import Arrived, Wish
from renderer.clip import Clip
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_clip

RATE = 25.0
"""Frames a second of what has no rate of its own."""


class PlayedSource:
    """Keeps to the clock: frames that a reader is too slow for are left out, as a camera would."""

    def __init__(self, path: Path, wish: Wish) -> None:
        """Raises ClipError: nothing that can be read, or frames of several sizes."""
        clip = open_clip(path, ClipOptions(depth="off", stereo="off"))
        self._clip, self._loop = clip, wish.loop
        self.frames_per_second = wish.frames_per_second or clip.frames_per_second or RATE
        self._times = _times(clip, self.frames_per_second, own=wish.frames_per_second is None)
        self._lasting = self._times[-1] + 1 / self.frames_per_second
        self._start: float | None = None
        self._next = 0

    @property
    def told(self) -> str:
        width, height = self._clip.size
        return f"{width} × {height}, {self.frames_per_second:.3g} frames/s, played from a file"

    def read(self) -> Arrived | None:
        if self._start is None:
            self._start = time.perf_counter()
        now = time.perf_counter() - self._start
        due = self._due(now)
        if due is None:
            return None
        missed, number = due - self._next, due
        taken = self._seconds(number)
        time.sleep(max(taken - now, 0.0))
        self._next = number + 1
        read = partial(self._clip.read_image, number % len(self._clip))
        aspect = self._clip.pixel_aspect
        return Arrived(read, self._start + taken, taken, missed, pixel_aspect=aspect)

    def close(self) -> None:
        """It holds nothing that is not let go of by itself."""

    def _due(self, now: float) -> int | None:
        """The frame to give at that time, counted through all rounds: the next, or the newest where that is
        late; None after the last."""
        rounds, within = divmod(now, self._lasting)
        newest = int(rounds) * len(self._clip) + bisect_right(self._times, within) - 1
        due = max(self._next, newest)
        return due if self._loop or due < len(self._clip) else None

    def _seconds(self, number: int) -> float:
        rounds, index = divmod(number, len(self._clip))
        return rounds * self._lasting + self._times[index]


def _times(clip: Clip, rate: float, *, own: bool) -> tuple[float, ...]:
    """Seconds at which frames arrive: the file's own, else evenly."""
    if own and clip.frame_times:
        return clip.frame_times
    return tuple(index / rate for index in range(len(clip)))
