"""Delays of the last frames: their median, 95 % and largest."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass
from typing import Final

import numpy as np

KEPT: Final = 600
"""The last frames: twenty seconds of most sources."""


@dataclass(frozen=True)
class Delay:
    """Of so many frames, in milliseconds."""

    frames: int
    median: float
    p95: float
    worst: float

    def __str__(self) -> str:
        return f"{self.median:.0f} ms median, {self.p95:.0f} ms p95, {self.worst:.0f} ms worst"


class Delays:
    """Written by one thread, read by others."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._seconds: deque[float] = deque(maxlen=KEPT)

    def add(self, seconds: float) -> None:
        with self._lock:
            self._seconds.append(seconds)

    @property
    def now(self) -> Delay | None:
        """None before the first frame."""
        with self._lock:
            known = np.array(self._seconds)
        if known.size == 0:
            return None
        return Delay(known.size, *(1000 * np.percentile(known, (50, 95, 100))).tolist())
