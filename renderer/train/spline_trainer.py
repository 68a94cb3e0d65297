"""Trains a SplineMotion: only the four control values that are active at a frame's time move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from renderer.camera import BoolArray
from renderer.deformation.nodes import Attachment, gather_gradients
from renderer.deformation.spline import spline_taps
from renderer.deformation.spline_motion import SplineMotion
from renderer.raw_gaussians import RawGaussians
from renderer.stored_arrays import Arrays
from renderer.train.adam import Moments, coast_taps, corrected_rate, update_taps
from renderer.train.rates import Rate

CURVES = ("position_controls", "color_controls", "opacity_controls", "node_controls")


@dataclass(frozen=True, kw_only=True)
class SplineRates:
    """Of the control values; positions in the clip's unit."""

    position: Rate
    color: Rate
    opacity: Rate
    smoothing: Rate
    """Share by which a control value is pulled to the mean of its neighbours in time, each step."""
    every_moment: bool = False
    """Control values far from a frame's time go on by their moments; else they rest."""


class SplineTrainer:
    """See MotionTrainer. Moments lie by control value, (K, N, C), as a step touches four of these."""

    def __init__(self, motion: SplineMotion, rates: SplineRates) -> None:
        self._rates = rates
        self._tap_steps = np.zeros(motion.n_controls, np.int64)
        self._moments = Moments.of({name: _by_control(getattr(motion, name)) for name in CURVES})
        self._take(motion)

    def _take(self, motion: SplineMotion) -> None:
        self.motion = motion
        n_nodes = len(motion.node_controls)
        self._links = Attachment.transposed(motion.node_indices, motion.node_weights, n_nodes)

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        return self.motion.moved(raw, time)

    def update(self, time: float, by: RawGaussians, seen: BoolArray, iteration: int) -> None:
        """See MotionTrainer; bias corrections count the updates of each control value."""
        start, weights = spline_taps(time, self.motion.n_controls)
        rates = self._rates
        active = slice(start, start + 4)
        moved = slice(None) if rates.every_moment else active
        self._tap_steps[moved] += 1
        corrections = np.ones(self.motion.n_controls)
        corrections[moved] = [corrected_rate(1.0, int(steps)) for steps in self._tap_steps[moved]]
        by_nodes, touched = self._gathered(by.means)
        touched |= rates.every_moment
        smoothing = rates.smoothing.at(iteration)
        for name, gradient, wanted, rate in (
            ("position_controls", by.means, seen, rates.position),
            ("color_controls", by.colors, seen, rates.color),
            ("opacity_controls", by.opacity_logits[:, None], seen, rates.opacity),
            ("node_controls", by_nodes, touched, rates.position),
        ):
            controls = getattr(self.motion, name)
            first, second = self._moments.first[name], self._moments.second[name]
            corrected = (corrections * rate.at(iteration)).astype(np.float32)
            update_taps(
                controls, gradient, first, second, wanted, start, weights, corrected[active], smoothing
            )
            if rates.every_moment:
                coast_taps(controls, first, second, start, corrected)

    def _gathered(self, by_means: NDArray[np.float32]) -> tuple[NDArray[np.float32], BoolArray]:
        by_nodes = np.empty((len(self.motion.node_controls), 3), np.float32)
        touched = np.empty(len(by_nodes), bool)
        links = self._links
        gather_gradients(links.starts, links.gaussians, links.weights, by_means, by_nodes, touched)
        return by_nodes, touched

    def choose(self, index: NDArray[np.int64]) -> None:
        """See MotionTrainer."""
        for moments in (self._moments.first, self._moments.second):
            for name in CURVES[:-1]:
                if moments[name].size:
                    moments[name] = moments[name].take(index, axis=1)
        self._take(self.motion.rows(index))

    def state(self) -> Arrays:
        """See MotionTrainer."""
        moments = {name: value.swapaxes(0, 1) for name, value in self._moments.arrays().items()}
        return self.motion.arrays() | moments | {"tap_steps": self._tap_steps}

    def restore(self, arrays: Arrays) -> None:
        """See MotionTrainer."""
        moments = {name: arrays[name].swapaxes(0, 1) for name in self._moments.arrays()}
        self._moments = Moments.from_arrays(moments, CURVES)
        self._tap_steps = arrays["tap_steps"].copy()
        self._take(SplineMotion.from_arrays({name: arrays[name].copy() for name in SplineMotion.NAMES}))


def _by_control(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """(K, N, C) of (N, K, C), in memory of its own."""
    return values.swapaxes(0, 1).copy()
