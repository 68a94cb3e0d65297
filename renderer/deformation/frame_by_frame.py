"""Gaussians given anew at each of several moments, as files of other programs have them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from renderer.raw_gaussians import RawGaussians
from renderer.stored_arrays import Arrays


@dataclass(frozen=True, eq=False)
class FrameByFrame:
    """Moment k of K is shown from (k - 1/2) / K to (k + 1/2) / K; their Gaussians have nothing to do with one
    another, and may differ in number. It is in no file of its own."""

    NAMES: ClassVar[tuple[str, ...]] = ()
    moments: tuple[RawGaussians, ...]

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        """See Motion; all of them, whatever `raw` is."""
        return self.moments[min(int(time * len(self.moments) + 0.5), len(self.moments) - 1)]

    def rows(self, index: NDArray[np.int64]) -> FrameByFrame:
        """Raises ValueError: a row is another Gaussian at every moment."""
        raise ValueError("expected Gaussians that move, got others at every moment")

    def arrays(self) -> Arrays:
        return {}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> FrameByFrame:
        """Raises ValueError: no file holds them together."""
        raise ValueError("expected a motion that a file holds")

    @classmethod
    def check(cls, arrays: Mapping[str, NDArray[Any]], count: int) -> None:
        """Raises ValueError: no file holds them together."""
        raise ValueError("expected a motion that a file holds")
