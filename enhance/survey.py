"""What the passes over one image find for its statistics."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from enhance.chroma import chroma_snr
from enhance.guided_filter import Grids

LIKELY_SIGMA: Final = 64.0
"""Of Q on real images, in grey levels; all that is needed of it before it is measured is that P is 1/2."""


@dataclass(frozen=True, eq=False)
class Survey:
    """What a first pass finds."""

    subsample: int
    low: Grids
    """(2, h, w) mean and variance of V in each block."""
    histogram: NDArray[np.int64]
    """(256,) of V over the kept pixels."""
    chroma: float
    """Sum of S over the kept pixels."""
    samples: NDArray[np.float64]
    """(3, n, m) of `chroma.sample_rows`."""
    full: int
    """The image's value of 1.0."""

    @cached_property
    def chroma_snr(self) -> float | None:
        """None: an image without colours, or too small to tell."""
        return chroma_snr(self.samples, self.full)

    @cached_property
    def cumulative(self) -> NDArray[np.int64]:
        """(256,) pixels of up to each V."""
        return self.histogram.cumsum()

    @cached_property
    def count(self) -> int:
        return int(self.cumulative[-1])

    @cached_property
    def mean(self) -> float:
        """Of V, in [0, 1]."""
        # Each pixel is above as many levels as its own is.
        above = 255 * self.count - int(self.cumulative[:-1].sum())
        return above / (255 * max(self.count, 1))

    def range(self, rounding: float) -> tuple[float, float]:
        """Darkest and brightest V counted, widened by what rounding hides, in grey levels."""
        levels = np.flatnonzero(self.histogram)
        return max(levels[0] - rounding, 0) / 255, min(levels[-1] + rounding, 255) / 255


class Moments(NamedTuple):
    """Of a scale's Q over the kept pixels, as in Tally."""

    mean: float
    squares: float

    @classmethod
    def of(cls, sums: tuple[float, float], seen: Survey) -> Moments:
        """From the sums of Q - the mean of V, and of its square."""
        count = max(seen.count, 1)
        drift = sums[0] / count
        return cls(float(np.float32(seen.mean)) + drift, max(sums[1] - count * drift**2, 0.0))

    def sigma(self, count: int) -> float:
        """In grey levels, over so many pixels."""
        return 255 * math.sqrt(self.squares / max(count, 1))
