"""Lengths and areas between points of the reconstruction's surface, at one moment of the clip."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from app.scenes.free_camera import Vector
from app.scenes.view_kinds import SCENE_UNITS
from renderer.camera import FloatArray

LEAST_CORNERS = 3
EXACT = 1e-9
"""Share of a length or an area below which its error is none."""


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
    """Points joined by straight lines. The tissue moves on; the points stay where it was at `time`."""

    located: tuple[Located, ...] = ()
    time: float = 0.0
    of: str = ""
    """The reconstruction whose surface it is: `Scene.identity`."""
    closed: bool = False
    """The line ends where it began, and goes around an area."""

    def with_point(self, point: Located, time: float, of: str = "", *, goes_on: bool = False) -> Measurement:
        """The second point, or the next of a line that goes on; the first of a new one after that, at
        another time, elsewhere."""
        count = len(self.located)
        if (self.time, self.of) == (time, of) and not self.closed and (count == 1 or (count and goes_on)):
            return Measurement((*self.located, point), time, of)
        return Measurement((point,), time, of)

    def as_outline(self) -> Measurement:
        """Closed; of fewer points than a triangle has, as it is."""
        return replace(self, closed=len(self.located) >= LEAST_CORNERS)

    @property
    def points(self) -> tuple[Vector, ...]:
        return tuple(one.point for one in self.located)

    @property
    def _line(self) -> FloatArray:
        """(N, 3) its points in order; of a closed one, the first comes again."""
        points = np.array(self.points, dtype=np.float64).reshape(-1, 3)
        return np.concatenate([points, points[:1]]) if self.closed else points

    @property
    def length(self) -> float | None:
        """Along the straight lines, of a closed one all around, in the scene's unit."""
        if len(self.located) < 2:
            return None
        return float(np.linalg.norm(np.diff(self._line, axis=0), axis=1).sum())

    @property
    def length_error(self) -> float:
        """Standard deviation of the length, of first order: depths err independently, along the rays by
        which the points were seen."""
        sections = np.diff(self._line, axis=0)
        lengths = np.linalg.norm(sections, axis=1, keepdims=True)
        ways = np.divide(sections, lengths, out=np.zeros_like(sections), where=lengths > 0)
        # A point lengthens the section that ends there and shortens the one that begins there.
        slopes = np.zeros((len(self._line), 3))
        slopes[1:] += ways
        slopes[:-1] -= ways
        if self.closed:
            slopes[0] += slopes[-1]
        return self._error(slopes)

    @property
    def area(self) -> float | None:
        """Of the flat area that a closed line goes around: where its points lie in no plane, that of the
        plane in which it is largest. In the square of the scene's unit."""
        return float(np.linalg.norm(self._normal)) if self.closed else None

    @property
    def area_error(self) -> float:
        """Standard deviation of the area, of first order, as `length_error`."""
        size, points = float(np.linalg.norm(self._normal)), self._line[:-1]
        if size == 0:
            return 0.0
        across = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
        return self._error(np.cross(across, self._normal / size) / 2)

    @property
    def _normal(self) -> FloatArray:
        """(3,) of the area, by its length: half the sum of the corners' cross products (Newell)."""
        line = self._line - self._line[0]
        return np.asarray(np.cross(line[:-1], line[1:]).sum(axis=0) / 2)

    def _error(self, slopes: FloatArray) -> float:
        """Of a number whose change as each point moves is known: (N, 3), rows beyond the points are left."""
        return math.hypot(
            *(
                one.error * float(np.dot(slope, one.ray))
                for one, slope in zip(self.located, slopes, strict=False)
            )
        )

    def text(self, unit: str) -> str:
        """Area and length as they are shown, with their errors where lengths have a scale; empty before
        there is one."""
        if self.length is None:
            return ""
        length = _text(self.length, self.length_error, unit, "")
        if self.area is None:
            return length
        return f"{_text(self.area, self.area_error, unit, '²')} · {length} around"


def _text(value: float, error: float, unit: str, power: str) -> str:
    # Three digits that count, and no power of ten.
    plain = np.format_float_positional(value, 3, unique=False, fractional=False, trim="-")
    if unit == SCENE_UNITS:
        return f"{plain} units{power} (no scale)"
    if error <= EXACT * value:
        return f"{plain} {unit}{power}"
    # Two digits of the error, as many decimals of the value.
    places = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{places}f} ± {error:.{places}f} {unit}{power}"
