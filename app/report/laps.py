"""Run times as the report states them: medians with their spread."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from renderer.measuring.interleaved_timing import interleaved_times


@dataclass(frozen=True)
class Laps:
    """Seconds."""

    median: float
    spread: float
    """Half of the distance between the quartiles."""


def laps(works: Sequence[Callable[[], object]], repeats: int) -> list[Laps]:
    """Of each work; they take turns, after one lap that does not count."""
    quartiles = np.percentile(interleaved_times(works, repeats), (25, 50, 75), axis=1).T.tolist()
    return [Laps(middle, (high - low) / 2) for low, middle, high in quartiles]
