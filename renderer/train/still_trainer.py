"""The trainer of a motion that does not exist."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from renderer.camera import BoolArray
from renderer.deformation.motion import Still
from renderer.raw_gaussians import RawGaussians
from renderer.stored_arrays import Arrays


class StillTrainer:
    """See MotionTrainer."""

    motion = Still()

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        return raw

    def update(self, time: float, by: RawGaussians, seen: BoolArray, iteration: int) -> None:
        """Nothing to do."""

    def choose(self, index: NDArray[np.int64]) -> None:
        """Nothing to do."""

    def state(self) -> Arrays:
        return {}

    def restore(self, arrays: Arrays) -> None:
        """Nothing to do."""
