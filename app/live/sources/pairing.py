"""Which frames of two sources are of one moment: by when they arrived."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from itertools import pairwise
from statistics import median
from typing import Final

from app.live.sources.source import Arrived

MEASURED: Final = 9
"""Arrivals of an eye from which it is measured how long a frame lasts: streams come in bursts."""
USUAL: Final = 1 / 25
"""Seconds that a frame lasts before that is measured."""


@dataclass(frozen=True, eq=False)
class Pair:
    """A left and a right frame of one moment."""

    left: Arrived
    right: Arrived
    late: int
    """Frames since the pair before that gave way to a newer one of the same eye."""
    unpaired: int
    """Pairs since then that were more than half a frame apart."""

    @property
    def apart(self) -> float:
        """Seconds from the arrival of one eye to that of the other."""
        return abs(self.left.at - self.right.at)


class Pairing:
    """Holds the newest frame of each eye. Two that arrived within half a frame of each other are a pair; of
    others the older is left out, and the newer waits for its partner."""

    def __init__(self) -> None:
        self.apart: float | None = None
        """Seconds between the newest of both eyes, whether they became a pair or not."""
        self._late, self._unpaired = 0, 0
        self._waiting: dict[int, Arrived] = {}
        self._arrivals = tuple(deque[float](maxlen=MEASURED) for _ in range(2))

    @property
    def frame(self) -> float:
        """Seconds that a frame of the quicker eye lasts."""
        known = [times for times in self._arrivals if len(times) > 2]
        lasting = [median(later - one for one, later in pairwise(times)) for times in known]
        return min(lasting, default=USUAL)

    def add(self, eye: int, arrived: Arrived) -> Pair | None:
        """eye: 0 of the left, 1 of the right. The pair that this frame completes, if it does."""
        self._arrivals[eye].append(arrived.at)
        self._late += arrived.missed + (eye in self._waiting)
        self._waiting[eye] = arrived
        if len(self._waiting) < 2:
            return None
        pair = Pair(self._waiting[0], self._waiting[1], self._late, self._unpaired)
        self.apart = pair.apart
        if pair.apart > self.frame / 2:
            self._unpaired += 1
            del self._waiting[0 if pair.left.at < pair.right.at else 1]
            return None
        self._waiting.clear()
        self._late, self._unpaired = 0, 0
        return pair
