"""The parts of a report, in their order, and how they share its time. Each is a file with a `measure`."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Final, cast

from app.report.bench import Measure


@dataclass(frozen=True)
class Part:
    """One section."""

    name: str
    share: float
    """Of the time, in relation to the others."""

    @property
    def measure(self) -> Measure:
        """Loads its module, and what that needs."""
        return cast(Measure, import_module(f"app.report.measures.{self.name}").measure)


PARTS: Final = (
    Part("enhancement", 1),
    Part("training", 100),
    Part("drawing", 2),
    Part("stability", 2),
    Part("left_out", 18),
    Part("paper", 25),
    Part("reading", 1),
    Part("growth", 3),
)
