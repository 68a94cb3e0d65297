"""What a method of reconstruction consists of: everything that the trainer itself does not decide."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from renderer.camera import BoolArray
from renderer.clip import Frame
from renderer.deformation.motion import Motion
from renderer.raw_gaussians import RawGaussians
from renderer.splats import RenderMode
from renderer.stored_arrays import Arrays
from renderer.train.densify import DensityControl
from renderer.train.losses import LossWeights
from renderer.train.rates import RowRates


class MotionTrainer(Protocol):
    """Trains the motion of a model; the motion itself may be replaced when Gaussians come and go."""

    @property
    def motion(self) -> Motion: ...

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        """As Motion.moved; may remember what `update` for the same frame needs."""
        ...

    def update(self, time: float, by: RawGaussians, seen: BoolArray, iteration: int) -> None:
        """One step from the gradients `by` the moved raw values; `seen` (N,) are those that have any."""
        ...

    def choose(self, index: NDArray[np.int64]) -> None:
        """Go on with these Gaussians, some perhaps repeated."""
        ...

    def state(self) -> Arrays:
        """The motion's arrays and all else that the next step depends on."""
        ...

    def restore(self, arrays: Arrays) -> None:
        """Take over what `state` gave; numbers of Gaussians may differ."""
        ...


@dataclass(frozen=True)
class Stage:
    """A part of the run."""

    steps: int
    half: bool = False
    """At half resolution."""
    moves: bool = True
    """False: the model is at rest."""
    first_frame_only: bool = False


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """A method, for one clip. Lengths are in scene sizes, so that units do not matter."""

    initialize: Callable[[Sequence[Frame]], RawGaussians]
    """From the frames to fit."""
    make_trainer: Callable[[RawGaussians, Sequence[Frame], float], MotionTrainer]
    """For the initial Gaussians, the frames to fit and the scene size."""
    rates: RowRates
    stages: tuple[Stage, ...]
    losses: LossWeights
    density: DensityControl | None = None
    """None: as many Gaussians as there were at first."""
    every_tile: bool = False
    """Draw tiles without tissue too, which no loss looks at."""
    every_moment: bool = False
    """What has no gradient in a step goes on by its moments, as Adam is published; else it rests."""
    mode: RenderMode = "default"
    """How splats narrower than a pixel are drawn, in training and after."""
    longest: float | None = None
    """Times its middle standard deviation that the largest of a Gaussian may be; None: any."""
    averaged_share: float = 0.0
    """Of the steps, at the end: the result is the mean of the models after them, see Average."""
    sh_degree: int = 0
    """Of the spherical harmonics at the end, 0 to 3: one more every sixth of the run."""

    @property
    def iterations(self) -> int:
        """Of all stages."""
        return sum(stage.steps for stage in self.stages)

    def degree_at(self, iteration: int) -> int:
        """Of the spherical harmonics in an iteration, counted from 0."""
        return min(self.sh_degree, 6 * iteration // self.iterations)

    def stage_at(self, iteration: int) -> Stage:
        """The stage that an iteration, counted from 0, belongs to."""
        end = 0
        for stage in self.stages:
            end += stage.steps
            if iteration < end:
                return stage
        raise ValueError(f"expected an iteration below {end}, got {iteration}")
