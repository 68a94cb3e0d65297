"""A stiff or extreme case, measured."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """One hazard: what was measured, and what it may be at most."""

    hazard: str
    case: str
    measured: float
    bar: float
    unit: str = "grey levels"
    done: str = ""
    """What the product does there, where that is more than to compute."""

    @property
    def passed(self) -> bool:
        """False also for NaN."""
        return self.measured <= self.bar
