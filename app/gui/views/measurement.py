"""A distance between two points of the reconstruction's surface, at one moment of the clip."""

from __future__ import annotations

import math
from dataclasses import dataclass

from app.scenes.free_camera import Vector
from app.scenes.view_kinds import SCENE_UNITS


@dataclass(frozen=True)
class Located:
    """A point of a surface and how well its depth is known."""

    point: Vector
    """In the world."""
    ray: Vector = (0.0, 0.0, 0.0)
    """How the point moves as its depth grows by one scene unit."""
    error: float = 0.0
    """Standard deviation of its depth, in scene units."""


@dataclass(frozen=True)
class Measurement:
    """Up to two points. The tissue moves on; the points stay where it was at `time`."""

    located: tuple[Located, ...] = ()
    time: float = 0.0
    of: str = ""
    """Name of the reconstruction whose surface it is."""

    def with_point(self, point: Located, time: float, of: str = "") -> Measurement:
        """The second point, or the first of a new distance: after two, at another time, elsewhere."""
        if len(self.located) == 1 and (self.time, self.of) == (time, of):
            return Measurement((*self.located, point), time, of)
        return Measurement((point,), time, of)

    @property
    def points(self) -> tuple[Vector, ...]:
        return tuple(one.point for one in self.located)

    @property
    def distance(self) -> float | None:
        """Along the straight line, in the scene's unit."""
        return math.dist(*self.points) if len(self.points) == 2 else None

    @property
    def error(self) -> float:
        """Standard deviation of the distance, of first order: both depths err independently, along the rays
        by which the points were seen."""
        if self.distance is None or self.distance == 0:
            return 0.0
        first, second = self.points
        way = [(b - a) / self.distance for a, b in zip(first, second, strict=True)]
        return math.hypot(
            *(one.error * sum(a * b for a, b in zip(way, one.ray, strict=True)) for one in self.located)
        )

    def text(self, unit: str) -> str:
        """The distance as it is shown, with its error where lengths have a scale; empty before there is
        one."""
        if self.distance is None:
            return ""
        if unit == SCENE_UNITS:
            return f"{self.distance:.3g} units (no scale)"
        if self.error == 0:
            return f"{self.distance:.3g} {unit}"
        # Two digits of the error, as many decimals of the distance.
        places = max(0, min(3, 1 - math.floor(math.log10(self.error))))
        return f"{self.distance:.{places}f} ± {self.error:.{places}f} {unit}"
