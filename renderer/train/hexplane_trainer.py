"""Trains a HexplaneMotion: only cells around a Gaussian that was seen move, and of time the two rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from renderer.camera import BoolArray
from renderer.deformation.heads import OFFSETS, PARTS
from renderer.deformation.hexplane import Layout, sample_backward, time_taps
from renderer.deformation.hexplane_motion import HexplaneMotion, Trace
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Float32Array
from renderer.stored_arrays import Arrays
from renderer.train.adam import Moments, corrected_rate, update_rows
from renderer.train.rates import Rate

FIXED = ("box", "unit", "resolutions")


@dataclass(frozen=True, kw_only=True)
class HexplaneRates:
    """Of the numbers, which have no unit, over the steps that the motion takes part in."""

    cells: Rate
    heads: Rate


class HexplaneTrainer:
    """See MotionTrainer."""

    def __init__(self, motion: HexplaneMotion, rates: HexplaneRates) -> None:
        self.motion, self._rates = motion, rates
        self._moments = Moments.of(_trained(motion))
        self._steps = np.zeros(1, np.int64)
        self._row_steps = np.zeros(len(motion.time_cells), np.int64)
        self._by_planes = np.empty_like(motion.plane_cells)
        self._trace: Trace | None = None

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        """See MotionTrainer."""
        self._trace = self.motion.traced(raw.means, time)
        return self.motion.offset(raw, self._trace.offsets)

    def update(self, time: float, by: RawGaussians, seen: BoolArray, iteration: int) -> None:
        """See MotionTrainer. Rates and bias corrections count the updates; of time planes, row by row."""
        assert self._trace is not None
        by_offsets = _by_offsets(by, seen, self.motion, len(self._trace.offsets))
        by_heads, by_features = self.motion.heads.backward(by_offsets, self._trace.activations)
        by_lines, touched = self._by_cells(self._trace, by_features, seen)
        done = int(self._steps[0])
        cell_rate, head_rate = self._rates.cells.at(done), self._rates.heads.at(done)
        self._steps += 1
        self._move("plane_cells", self._by_planes, touched, corrected_rate(cell_rate, done + 1))
        for name, gradient in by_heads.arrays().items():
            everywhere = np.ones(_rows(gradient).shape[0], bool)
            self._move(name, gradient, everywhere, corrected_rate(head_rate, done + 1))
        row, share = time_taps(time, len(self._row_steps))
        # Adam as published averages squares over the steps without gradient too, all but two in so many
        # rows: a row goes further at a step by the root of that.
        row_rate = cell_rate * (len(self._row_steps) / 2) ** 0.5
        crossed: BoolArray = np.any(by_lines, axis=2)
        for tap, weight in ((row, 1 - share), (row + 1, share)):
            if weight > 0:
                self._row_steps[tap] += 1
                rate = corrected_rate(row_rate, int(self._row_steps[tap]))
                self._move("time_cells", weight * by_lines, crossed, rate, tap)

    def _by_cells(
        self, trace: Trace, by_features: Float32Array, seen: BoolArray
    ) -> tuple[Float32Array, BoolArray]:
        """Gradient by the line cells, and which plane cells have one; theirs stays in `_by_planes`."""
        planes, layout = self.motion.plane_cells, Layout.of(self.motion.resolutions)
        by_lines, touched = np.empty_like(trace.line_cells), np.empty(planes.shape[:2], bool)
        sample_backward(
            planes, trace.line_cells, layout.resolutions, layout.planes, layout.lines,
            trace.points, seen, by_features, self._by_planes, by_lines, touched,
        )  # fmt: skip
        return by_lines, touched

    def _move(
        self, name: str, gradient: Float32Array, touched: BoolArray, rate: float, part: int | None = None
    ) -> None:
        """One Adam step of an array, or of its `part` along the first axis."""
        arrays = self.motion.arrays()[name], self._moments.first[name], self._moments.second[name]
        values, first, second = (_rows(array if part is None else array[part]) for array in arrays)
        update_rows(values, _rows(gradient), first, second, touched.ravel(), rate)

    def choose(self, index: NDArray[np.int64]) -> None:
        """Nothing to do: nothing is per Gaussian."""

    def state(self) -> Arrays:
        """See MotionTrainer."""
        counts = {"motion_steps": self._steps, "row_steps": self._row_steps}
        return self.motion.arrays() | self._moments.arrays() | counts

    def restore(self, arrays: Arrays) -> None:
        """See MotionTrainer."""
        self.motion = HexplaneMotion.from_arrays({name: arrays[name].copy() for name in HexplaneMotion.NAMES})
        self._moments = Moments.from_arrays(arrays, _trained(self.motion))
        self._steps, self._row_steps = arrays["motion_steps"].copy(), arrays["row_steps"].copy()


def _trained(motion: HexplaneMotion) -> Arrays:
    return {name: value for name, value in motion.arrays().items() if name not in FIXED}


def _rows(values: Float32Array) -> Float32Array:
    """All but the last axis as one, a view."""
    return values.reshape(-1, values.shape[-1])


def _by_offsets(by: RawGaussians, seen: BoolArray, motion: HexplaneMotion, count: int) -> Float32Array:
    """Gradient by the offsets (count, OFFSETS); rows beyond the Gaussians and of unseen ones are 0."""
    gradient = np.zeros((count, OFFSETS), np.float32)
    for part, values in zip(PARTS, (motion.unit * by.means, by.log_scales, by.quats), strict=True):
        gradient[: len(values), part] = np.where(seen[:, None], values, np.float32(0.0))
    return gradient
