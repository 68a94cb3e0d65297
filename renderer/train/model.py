"""The model in training: its values, their Adam moments, and one step on one frame. No torch."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace

import numpy as np

from renderer.camera import BoolArray
from renderer.gaussians import DynamicGaussians
from renderer.harmonics import BANDS
from renderer.raw_gaussians import FIELDS, RawGaussians
from renderer.splats import Float32Array
from renderer.stored_arrays import Arrays, check_state
from renderer.train.adam import Moments, corrected_rate, update_rows
from renderer.train.average import Average
from renderer.train.densify import Densifier, Plan
from renderer.train.frames import TrainFrame
from renderer.train.gradient_backend import CpuBackend, GradientBackend
from renderer.train.guards import Trouble, hold_scales, leave_out_broken, shorten
from renderer.train.losses import Measured
from renderer.train.recipe import MotionTrainer, Recipe

SHORTENED_EVERY = 10
"""Steps."""


class TrainModel:
    """Trains Gaussians and their motion. `size` is the scene size in the clip's unit; `pictures` draws, by
    the numba kernels when there is none."""

    def __init__(
        self,
        raw: RawGaussians,
        motion: MotionTrainer,
        recipe: Recipe,
        size: float,
        pictures: GradientBackend | None = None,
    ) -> None:
        self.raw = raw
        self._pictures: GradientBackend = pictures or CpuBackend()
        self._motion, self._recipe, self._size = motion, recipe, size
        self._moments = Moments.of(raw.arrays())
        self._density = Densifier(recipe.density, size, len(raw)) if recipe.density else None
        self._average = Average(recipe.iterations, round(recipe.averaged_share * recipe.iterations))
        self.trouble = Trouble()

    def __len__(self) -> int:
        return len(self.raw)

    @property
    def gaussians(self) -> DynamicGaussians:
        """The model as it stands; later steps change its arrays."""
        return DynamicGaussians(self.raw, self._motion.motion)

    @property
    def result(self) -> DynamicGaussians:
        """What training gives, after its last step."""
        return self._average.of(self.gaussians)

    def snapshot(self) -> DynamicGaussians:
        """A copy that later steps leave alone."""
        return deepcopy(self.gaussians)

    def state(self) -> Arrays:
        """Values, moments and counters: all that the next step depends on."""
        density = self._density.state() if self._density else {}
        of_steps = self.raw.arrays() | self._moments.arrays() | density | self._motion.state()
        return of_steps | self._average.state()

    def restore(self, arrays: Arrays) -> None:
        """Take over what `state` gave.

        Raises:
            ValueError: these are not the arrays of a training like this one.
        """
        check_state(arrays, self.state())
        DynamicGaussians.checked(arrays)
        self.raw = RawGaussians.from_arrays({name: arrays[name].copy() for name in FIELDS})
        self._moments = Moments.from_arrays(arrays, FIELDS)
        if self._density:
            self._density.restore(arrays)
        self._motion.restore(arrays)
        self._average.restore(arrays)

    def step(self, frame: TrainFrame, iteration: int) -> Measured:
        """One update from one frame; `iteration` counts from 0."""
        self._raise_degree(BANDS[self._recipe.degree_at(iteration)])
        moves = self._recipe.stage_at(iteration).moves
        now = self._motion.moved(self.raw, frame.time) if moves else self.raw
        recipe = self._recipe
        slopes = self._pictures.loss_and_gradients(
            now, frame, recipe.losses, self._size, every_tile=recipe.every_tile, mode=recipe.mode
        )
        by, reached = slopes.by, slopes.seen.copy()
        self.trouble.not_finite += leave_out_broken(by, reached)
        # Those that are broken stay where they are; those that no tile reaches move by their moments alone.
        updated = reached | ~slopes.seen if recipe.every_moment else reached
        self._update(by, updated, iteration)
        if moves:
            self._motion.update(frame.time, by, updated, iteration)
        self.trouble.held += hold_scales(self.raw.log_scales, self._size)
        if recipe.longest is not None and (iteration + 1) % SHORTENED_EVERY == 0:
            shorten(self.raw.log_scales, recipe.longest)
        if self._density:
            self._density.add(self._pictures.by_centers(), reached, frame.camera)
            if self._density.is_due(iteration + 1):
                self._carry_out(self._density.plan(self.raw, iteration + 1))
        self._average.add(self.gaussians, iteration + 1)
        return slopes.measured

    def _raise_degree(self, bands: int) -> None:
        """Harmonics of `bands` functions: the new ones are 0."""
        more = bands - self.raw.harmonics.shape[1]
        if more > 0:
            none = np.zeros((len(self.raw), more, 3), np.float32)
            self.raw = replace(self.raw, harmonics=np.concatenate([self.raw.harmonics, none], axis=1))
            for moments in (self._moments.first, self._moments.second):
                moments["harmonics"] = np.concatenate([moments["harmonics"], none], axis=1)

    def _carry_out(self, plan: Plan) -> None:
        """Change the number of Gaussians."""
        self.raw = replace(self.raw.rows(plan.index), means=plan.means, log_scales=plan.log_scales)
        for moments in (self._moments.first, self._moments.second):
            for name in FIELDS:
                moments[name] = moments[name][plan.index]
                moments[name][plan.fresh] = 0.0
        self._motion.choose(plan.index)
        assert self._density is not None
        self._density.start_again(len(plan.index))

    def _update(self, by: RawGaussians, seen: BoolArray, iteration: int) -> None:
        for name in FIELDS:
            values = getattr(self.raw, name)
            if values.size == 0:
                continue
            rate = getattr(self._recipe.rates, name).at(iteration)
            rate = corrected_rate(rate * self._size if name == "means" else rate, iteration + 1)
            moments = _flat(self._moments.first[name]), _flat(self._moments.second[name])
            update_rows(_flat(values), _flat(getattr(by, name)), *moments, seen, rate)


def _flat(values: Float32Array) -> Float32Array:
    """(N, numbers of each), a view."""
    return values.reshape(len(values), -1)
