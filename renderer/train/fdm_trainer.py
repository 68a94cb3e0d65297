"""Trains a FlexibleMotion: only the bumps that count at a frame's time are read and move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.camera import BoolArray
from renderer.deformation.fdm import (
    CENTRE,
    CHANNELS,
    FIRST,
    FLOOR,
    LAST,
    LOG2_E,
    MAX_U,
    POSITION,
    TASK,
    WEIGHT,
    WIDTH,
    FlexibleMotion,
    measure_span,
)
from renderer.rasterize.exp2 import exp2
from renderer.raw_gaussians import RawGaussians
from renderer.stored_arrays import Arrays
from renderer.train.adam import Moments, adam_update, corrected_rate
from renderer.train.rates import Rate

FOUR = np.float32(4.0)


@dataclass(frozen=True, kw_only=True)
class FdmRates:
    """Of the bumps."""

    position: Rate
    """Of the weights of positions, in the clip's unit."""
    other: Rate
    """Of the other weights, the centres and the widths."""


class FdmTrainer:
    """See MotionTrainer.

    The moments of what does not count at a frame's time rest, where Adam as published lets them decay:
    over a few thousand steps their sums are nearly the same. Bias corrections are by the step of the run.
    """

    def __init__(self, motion: FlexibleMotion, rates: FdmRates) -> None:
        self.motion = motion
        self._rates = rates
        self._moments = Moments.of(motion.arrays())

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        return self.motion.moved(raw, time)

    def update(self, time: float, by: RawGaussians, seen: BoolArray, iteration: int) -> None:
        """See MotionTrainer."""
        rates = np.full((3, CHANNELS), self._rates.other.at(iteration), np.float32)
        rates[WEIGHT, POSITION] = self._rates.position.at(iteration)
        rates *= np.float32(corrected_rate(1.0, iteration + 1))
        gradients = np.concatenate([by.means, by.quats, by.log_scales], axis=1)
        moments = self._moments.first["bumps"], self._moments.second["bumps"]
        update_bumps(self.motion.bumps, self.motion.spans, *moments, gradients, seen, time, rates)

    def choose(self, index: NDArray[np.int64]) -> None:
        """See MotionTrainer."""
        self.motion = self.motion.rows(index)
        for moments in (self._moments.first, self._moments.second):
            moments["bumps"] = moments["bumps"][:, index]

    def state(self) -> Arrays:
        """See MotionTrainer."""
        return self.motion.arrays() | self._moments.arrays()

    def restore(self, arrays: Arrays) -> None:
        """See MotionTrainer."""
        self.motion = FlexibleMotion(arrays["bumps"].copy())
        self._moments = Moments.from_arrays(arrays, self.motion.arrays())


@njit(parallel=True, cache=True, error_model="numpy")
def update_bumps(
    bumps: NDArray[np.float32],  # (B, N, 3, C), updated
    spans: NDArray[np.float32],  # (B, N, 2), updated
    first: NDArray[np.float32],  # (B, N, 3, C), updated
    second: NDArray[np.float32],  # (B, N, 3, C), updated
    gradients: NDArray[np.float32],  # (N, C), by the channels' values
    seen: NDArray[np.bool_],  # (N,)
    time: float,
    rates: NDArray[np.float32],  # (3, C)
) -> None:
    """One step of Adam on the bumps with u <= MAX_U at `time`; the others rest.

    With e = exp(-u^2) and q = s^2 + 1e-4: by w is e, by m is 4 w e u (t - m) / q, by s is 4 w e u^2 s / q,
    each times the gradient of the channel.
    """
    now, count = np.float32(time), bumps.shape[1]
    for task in prange((count + TASK - 1) // TASK):
        for j in range(len(bumps)):
            for n in range(task * TASK, min(task * TASK + TASK, count)):
                if seen[n] and spans[j, n, FIRST] <= now <= spans[j, n, LAST]:
                    _update_bump(bumps, first, second, gradients, now, rates, j, n)
                    measure_span(bumps, spans, j, n)


@njit(forceinline=True, error_model="numpy")
def _update_bump(
    bumps: NDArray[np.float32],
    first: NDArray[np.float32],
    second: NDArray[np.float32],
    gradients: NDArray[np.float32],
    now: np.float32,
    rates: NDArray[np.float32],
    j: int,
    n: int,
) -> None:
    """Of one function of one Gaussian."""
    for c in range(CHANNELS):
        away, width = now - bumps[j, n, CENTRE, c], bumps[j, n, WIDTH, c]
        square = width * width + FLOOR
        u = away * away / square
        if u > MAX_U:
            continue
        by_weight = gradients[n, c] * exp2(-LOG2_E * u * u)
        slope = FOUR * bumps[j, n, WEIGHT, c] * by_weight * u / square
        for part, gradient in ((WEIGHT, by_weight), (CENTRE, slope * away), (WIDTH, slope * u * width)):
            bumps[j, n, part, c], first[j, n, part, c], second[j, n, part, c] = adam_update(
                bumps[j, n, part, c], gradient, first[j, n, part, c], second[j, n, part, c], rates[part, c]
            )
