"""Curves of a grid of nodes, fitted to what was seen of their shifts between frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from renderer.camera import FloatArray
from renderer.deformation.spline import spline_taps

NEIGHBOURS = 0.3
"""Weight of the squared difference of neighbouring nodes, against a shift that is well seen."""
STEADY = 0.05
"""Weight of the squared second difference of control values in time."""
RIDGE = 1e-3
"""Weight of the squared control values: nodes that nothing was seen of rest at last."""
CLOSE, ROUGH = 1e-10, 1e-4
"""Of the residual's square, relative to that of the start: for curves in use, and to compare fits. On three
clips the second gives misses within 0.02 px of those of 1e-6, in half the time."""
MOST_ROUNDS = 500


@dataclass(frozen=True, eq=False)
class Seen:
    """Shifts of M nodes from one frame to F others."""

    reference: int
    frames: slice
    shifts: FloatArray
    """(F, M, 3)"""
    weights: FloatArray
    """(F, M), 0 where nothing was seen."""


@dataclass(frozen=True, eq=False)
class CurveFit:
    """The least squares problem of the control values (K, M, 3), whose mean over the frames is drawn to 0."""

    first: NDArray[np.int64]
    """(n,) first active control value of each frame, in the order of time."""
    taps: FloatArray
    """(n, 4)"""
    n_controls: int
    grid: tuple[int, int]
    seen: tuple[Seen, ...]

    @classmethod
    def of(
        cls, times: Sequence[float], n_controls: int, grid: tuple[int, int], seen: tuple[Seen, ...]
    ) -> Self:
        """For frames at rising times in [0, 1]."""
        active = [spline_taps(time, n_controls) for time in times]
        taps = np.array([weights for _, weights in active], np.float64)
        return cls(np.array([first for first, _ in active]), taps, n_controls, grid, seen)

    def solved(self, tolerance: float = CLOSE) -> FloatArray:
        """The control values (K, M, 3), by conjugate gradients."""
        rest = self._transposed([one.weights[:, :, None] * one.shifts for one in self.seen])
        controls, scale = np.zeros_like(rest), 1 / self._diagonal()
        step = direction = scale * rest
        size = start = float((rest * step).sum())
        for _ in range(MOST_ROUNDS):
            if size <= tolerance * start:
                break
            image = self._times(direction)
            length = size / float((direction * image).sum())
            controls += length * direction
            rest = rest - length * image
            step = scale * rest
            before, size = size, float((rest * step).sum())
            direction = step + size / before * direction
        return controls

    def _times(self, controls: FloatArray) -> FloatArray:
        """The matrix of the normal equations times (K, M, 3)."""
        curves = self.curves(controls)
        shifts = [one.weights[:, :, None] * (curves[one.frames] - curves[one.reference]) for one in self.seen]
        out = self._transposed(shifts) + RIDGE * controls
        out += self._summed(np.broadcast_to(curves.mean(axis=0), curves.shape)) / len(curves)
        if self.n_controls > 2:
            out += STEADY * _bent(np.diff(controls, n=2, axis=0))
        columns, rows = self.grid
        field = controls.reshape(self.n_controls, rows, columns, 3)
        apart = _differences(field, 1) + _differences(field, 2)
        return out + NEIGHBOURS * apart.reshape(controls.shape)

    def curves(self, controls: FloatArray) -> FloatArray:
        """(n, M, 3) values at the frames, of control values (K, M, 3)."""
        return np.asarray(sum(self.taps[:, tap, None, None] * controls[self.first + tap] for tap in range(4)))

    def _summed(self, values: FloatArray) -> FloatArray:
        """Transpose of `curves`."""
        out = np.zeros((self.n_controls, *values.shape[1:]))
        active, starts = np.unique(self.first, return_index=True)
        for tap in range(4):
            out[active + tap] += np.add.reduceat(self.taps[:, tap, None, None] * values, starts, axis=0)
        return out

    def _transposed(self, shifts: Sequence[FloatArray]) -> FloatArray:
        """Of what takes controls to the shifts that are seen."""
        columns, rows = self.grid
        by_frame = np.zeros((len(self.first), columns * rows, 3))
        for one, shift in zip(self.seen, shifts, strict=True):
            by_frame[one.frames] += shift
            by_frame[one.reference] -= shift.sum(axis=0)
        return self._summed(by_frame)

    def _diagonal(self) -> FloatArray:
        """(K, M, 1) of the matrix, but for that of the means, as a preconditioner."""
        basis = np.zeros((len(self.first), self.n_controls))
        np.put_along_axis(basis, self.first[:, None] + np.arange(4), self.taps, axis=1)
        columns, rows = self.grid
        out = np.full((self.n_controls, columns * rows), RIDGE + 6 * STEADY + 4 * NEIGHBOURS)
        for one in self.seen:
            out += np.einsum("fk,fm->km", (basis[one.frames] - basis[one.reference]) ** 2, one.weights)
        return out[:, :, None]


def _bent(second: FloatArray) -> FloatArray:
    """Transpose of the second difference along the first axis."""
    out = np.zeros((len(second) + 2, *second.shape[1:]))
    out[:-2] += second
    out[1:-1] -= 2 * second
    out[2:] += second
    return out


def _differences(field: FloatArray, axis: int) -> FloatArray:
    """What neighbours along an axis differ by, summed at each: the matrix of their squared differences."""
    across = np.moveaxis(field, axis, 0)
    out = np.zeros_like(across)
    apart = np.diff(across, axis=0)
    out[1:] += apart
    out[:-1] -= apart
    return np.moveaxis(out, 0, axis)
