"""How a cost grows with the work: a power law fitted on logarithmic axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray


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
