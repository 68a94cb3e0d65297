"""Error against run time: settings as points, the Pareto front, and the setting to use for a bound."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Point:
    """A setting, measured."""

    series: str
    """What it is drawn with."""
    setting: str
    seconds: float
    error: float
    spread: float = 0.0
    """Of the seconds: half of the distance between the quartiles."""
    is_default: bool = False


@dataclass(frozen=True, kw_only=True)
class Diagram:
    """Points of one measure."""

    measure: str
    """Name and unit, for the axis."""
    points: tuple[Point, ...]
    more_is_better: bool = False
    """A measure on a linear axis, such as PSNR; else an error, on a logarithmic one."""


def pareto_front(diagram: Diagram) -> tuple[Point, ...]:
    """The points that no other beats in one of time and error without losing in the other; fastest first."""
    sign = -1.0 if diagram.more_is_better else 1.0
    finite = [point for point in diagram.points if math.isfinite(point.error)]
    front: list[Point] = []
    for point in sorted(finite, key=lambda point: (point.seconds, sign * point.error)):
        if not front or sign * point.error < sign * front[-1].error:
            front.append(point)
    return tuple(front)


def within_budget(diagram: Diagram, seconds: float) -> Point | None:
    """The most exact setting that takes no longer; None when all take longer."""
    fast = [point for point in pareto_front(diagram) if point.seconds <= seconds]
    return fast[-1] if fast else None


def within_error(diagram: Diagram, error: float) -> Point | None:
    """The fastest setting whose error is no larger, or whose measure is no less where more is better."""
    sign = -1.0 if diagram.more_is_better else 1.0
    return next((point for point in pareto_front(diagram) if sign * point.error <= sign * error), None)
