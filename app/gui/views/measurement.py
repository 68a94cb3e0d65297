"""A distance between two points of the reconstruction's surface, at one moment of the clip."""

from __future__ import annotations

import math
from dataclasses import dataclass

from app.scenes.free_camera import Vector
from app.scenes.view_kinds import SCENE_UNITS


@dataclass(frozen=True)
class Measurement:
    """Up to two points in the world. The tissue moves on; the points stay where it was at `time`."""

    points: tuple[Vector, ...] = ()
    time: float = 0.0
    of: str = ""
    """Name of the reconstruction whose surface it is."""

    def with_point(self, point: Vector, time: float, of: str = "") -> Measurement:
        """The second point, or the first of a new distance: after two, at another time, elsewhere."""
        if len(self.points) == 1 and (self.time, self.of) == (time, of):
            return Measurement((*self.points, point), time, of)
        return Measurement((point,), time, of)

    @property
    def distance(self) -> float | None:
        """Along the straight line, in the scene's unit."""
        return math.dist(*self.points) if len(self.points) == 2 else None

    def text(self, unit: str) -> str:
        """The distance as it is shown; empty before there is one."""
        if self.distance is None:
            return ""
        return f"{self.distance:.3g} {'units' if unit == SCENE_UNITS else unit}"
