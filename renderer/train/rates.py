"""Learning rates over a run."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Rate:
    """Constant for `held` steps, then log-linear from `start` to `end` up to `steps`, then constant."""

    start: float
    end: float
    steps: int
    held: int = 0

    @classmethod
    def constant(cls, value: float) -> Rate:
        return cls(value, value, 1)

    def at(self, iteration: int) -> float:
        """At an iteration, counted from 0."""
        if self.start == 0:
            return 0.0
        gone = max(iteration - self.held, 0) / max(self.steps - self.held, 1)
        return float(self.start * (self.end / self.start) ** min(gone, 1.0))


@dataclass(frozen=True, kw_only=True)
class RowRates:
    """Of each array of RawGaussians; that of the means in scene sizes."""

    means: Rate
    quats: Rate
    log_scales: Rate
    opacity_logits: Rate
    colors: Rate
    harmonics: Rate
