"""Diagrams as values: error against run time and contrast against noise, each with its Pareto front; cost
against work with its power law."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

Kind = TypeVar("Kind")

TICKS: Final = {6: (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0), 300: (1.0, 2.0, 5.0)}


def of_a_decade(least: float, most: float) -> tuple[float, ...]:
    """More numbers the fewer decades an axis has."""
    span = most / least if least > 0 else float("inf")
    return next((digits for ratio, digits in TICKS.items() if span < ratio), (1.0,))


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


@dataclass(frozen=True)
class TimeUnit:
    """What run times are counted in."""

    name: str
    of_a_second: float
    """How many a second has."""


SECONDS: Final = TimeUnit("s", 1.0)
MILLISECONDS: Final = TimeUnit("ms", 1e3)


@dataclass(frozen=True, kw_only=True)
class Diagram:
    """Points of one measure."""

    measure: str
    """Name and unit, for the axis."""
    points: tuple[Point, ...]
    more_is_better: bool = False
    """A measure on a linear axis, such as PSNR; else an error, on a logarithmic one."""

    @property
    def unit(self) -> TimeUnit:
        """In which the run times are read best."""
        finite = [point.seconds for point in self.points if math.isfinite(point.error)]
        return SECONDS if max(finite, default=0.0) >= 1 else MILLISECONDS


def pareto_front(diagram: Diagram) -> tuple[Point, ...]:
    """The points that no other beats in one of time and error without losing in the other; fastest first."""
    sign = -1.0 if diagram.more_is_better else 1.0
    finite = [point for point in diagram.points if math.isfinite(point.error)]
    return _undominated(finite, lambda point: (point.seconds, sign * point.error))


def _undominated(points: Iterable[Kind], price: Callable[[Kind], tuple[float, float]]) -> tuple[Kind, ...]:
    """Of two prices, less is better; by the first, cheapest first. Of equal points, the first one."""
    front: list[Kind] = []
    for point in sorted(points, key=price):
        if not front or price(point)[1] < price(front[-1])[1]:
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


@dataclass(frozen=True, kw_only=True)
class Gain:
    """What a method at one setting does to an image; 1 = as in the original."""

    series: str
    """What it is drawn with."""
    setting: str
    noise: float
    """Times the noise of the original."""
    contrast: float
    """Times the contrast of its vessels."""
    is_default: bool = False


@dataclass(frozen=True, kw_only=True)
class GainDiagram:
    """Gains of one set of images, all above 0: the axes are logarithmic. A line joins those of a series."""

    title: str
    gains: tuple[Gain, ...]


def gain_front(diagram: GainDiagram) -> tuple[Gain, ...]:
    """The gains than which no other has more contrast with no more noise; the least noise first."""
    return _undominated(diagram.gains, lambda gain: (gain.noise, -gain.contrast))


@dataclass(frozen=True, kw_only=True)
class Curve:
    """Measurements of one thing."""

    name: str
    work: tuple[float, ...]
    cost: tuple[float, ...]
    exponent: float
    """Slope of the least-squares line through the logarithms: 1 is in proportion, 0 is no growth."""

    @classmethod
    def through(cls, name: str, work: Sequence[float], cost: Sequence[float]) -> Self:
        """With its exponent fitted."""
        return cls(name=name, work=tuple(work), cost=tuple(cost), exponent=fitted(work, cost)[0])

    @property
    def label(self) -> str:
        """Name and exponent, as legends have them."""
        return f"{self.name}: exponent {self.exponent:z.2f}"

    def law(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Least and most work, and what the fitted power law gives for them."""
        exponent, factor = fitted(self.work, self.cost)
        ends = np.array([min(self.work), max(self.work)], np.float64)
        return ends, factor * ends**exponent


@dataclass(frozen=True, kw_only=True)
class Growth:
    """Curves over one kind of work."""

    title: str
    work: str
    """Name and unit, for the axis."""
    cost: str
    curves: tuple[Curve, ...]


def fitted(work: Sequence[float], cost: Sequence[float]) -> tuple[float, float]:
    """Exponent and factor of cost = factor work^exponent; NaN from fewer than two amounts of work."""
    pairs = [(w, c) for w, c in zip(work, cost, strict=True) if w > 0 and c > 0]
    if len({w for w, _ in pairs}) < 2:
        return math.nan, math.nan
    logs = np.log(np.array(pairs, dtype=np.float64))
    exponent, level = np.polyfit(logs[:, 0], logs[:, 1], 1)
    return float(exponent), float(np.exp(level))
