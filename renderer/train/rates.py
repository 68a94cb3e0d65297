"""Learning rates over a run."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Rate:
    """Log-linear from `start` to `end` over `steps`, then constant."""

    start: float
    end: float
    steps: int

    @classmethod
    def constant(cls, value: float) -> Rate:
        return cls(value, value, 1)

    def at(self, iteration: int) -> float:
        """At an iteration, counted from 0."""
        if self.start == 0:
            return 0.0
        return float(self.start * (self.end / self.start) ** min(iteration / self.steps, 1.0))


@dataclass(frozen=True, kw_only=True)
class RowRates:
    """Of each array of RawGaussians; that of the means in scene sizes."""

    means: Rate
    quats: Rate
    log_scales: Rate
    opacity_logits: Rate
    colors: Rate
    harmonics: Rate
