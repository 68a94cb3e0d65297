"""A stiff or extreme case, measured."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Row:
    """What was measured, and what it may be at most."""

    hazard: str
    """The equation or kernel, and what can go wrong."""
    case: str
    measured: float
    bar: float
    unit: str
    done: str = ""
    """What the product does there, where that is more than to compute."""

    @property
    def passed(self) -> bool:
        """False also for NaN."""
        return self.measured <= self.bar


def worst(errors: Iterable[float]) -> float:
    """The largest, 0 of none; NaN where any is, which `max` passes over."""
    return float(np.max(np.fromiter(errors, np.float64), initial=0.0))
