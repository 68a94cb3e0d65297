"""What moves Gaussians in time by splines: curves, the nodes that neighbours share, and their training."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from renderer.deformation.nodes import attach, node_grid
from renderer.deformation.spline import spline_taps
from renderer.deformation.spline_motion import SplineMotion
from renderer.measuring.stability import exact_adam
from renderer.measuring.stability.row import Row, worst
from renderer.measuring.stability.scenes import CAMERA, noisy_gradients, ordinary, raw_of
from renderer.raw_gaussians import RawGaussians
from renderer.train.rates import Rate
from renderer.train.spline_trainer import CURVES, SplineRates, SplineTrainer

FloatArray = NDArray[np.float64]
TIMES = (0.0, 1e-9, 0.1, 0.5, 1 - 1e-9, 1.0, -3.0, 3.0)
"""The last two lie outside a clip and are those of its ends."""
SPLINE = "cubic spline in time"
CONTROLS = 17
RATE, SMOOTHING = 1e-3, 0.01


def splines() -> Iterator[Row]:
    """Weights against the recursion of Cox and de Boor; whole motions and their training in float64."""
    for controls in (4, 17, 1000):
        errors = []
        for time in TIMES:
            _, weights = spline_taps(time, controls)
            wanted = _de_boor(min(max(time, 0.0), 1.0), controls)
            errors += [np.abs(_weights(time, controls) - wanted).max(), abs(float(weights.sum()) - 1)]
        case = f"{controls} control values, at and beyond both ends"
        yield Row(SPLINE, case, worst(errors), 2e-7, "of 1")
    jumps = []
    for knot in range(1, 14):
        before, after = (_weights(knot / 14 + side, CONTROLS) for side in (-1e-7, 1e-7))
        jumps.append(float(np.abs(before - after).max()))
    yield Row(SPLINE, "step across a knot of 2e-7 of the clip", worst(jumps), 5e-6, "of 1")
    yield Row(SPLINE, "3 control values are not refused", float(not _refused()), 0, "cases",
              "ValueError: at least 4")  # fmt: skip
    yield from _moved()
    yield from _trained()


def _weights(time: float, controls: int) -> FloatArray:
    first, weights = spline_taps(time, controls)
    whole = np.zeros(controls)
    whole[first : first + 4] = weights
    return whole


def _refused() -> bool:
    try:
        spline_taps(0.5, 3)
    except ValueError as refusal:
        return "at least 4 control values" in str(refusal)
    return False


def _de_boor(time: float, controls: int) -> FloatArray:
    """The uniform cubic basis (K,) at a time, by recursion."""
    place = time * (controls - 3)
    knots = np.arange(-3.0, controls + 1)
    last = controls - 3
    basis = ((knots[:-1] <= place) & (place < knots[1:])).astype(float)
    if place == last:
        basis[:] = 0
        basis[np.searchsorted(knots, last) - 1] = 1
    for degree in range(1, 4):
        count = len(knots) - 1 - degree
        left = (place - knots[:count]) / degree * basis[:count]
        right = (knots[degree + 1 : degree + 1 + count] - place) / degree * basis[1 : count + 1]
        basis = left + right
    return basis


def _motion(raw: RawGaussians) -> SplineMotion:
    """Of random curves, on nodes over the view."""
    rng, grid = np.random.default_rng(4), node_grid(CAMERA, 6)
    indices, weights = attach(raw.means, CAMERA, grid)
    count = len(raw)
    lengths = {"node_controls": grid[0] * grid[1]}
    channels = {"opacity_controls": 1}
    curves = {
        name: rng.normal(size=(lengths.get(name, count), CONTROLS, channels.get(name, 3))).astype(np.float32)
        for name in CURVES
    }
    return SplineMotion(**curves, node_indices=indices, node_weights=weights)


def _moved() -> Iterator[Row]:
    """Positions, colours and logits at all times."""
    raw = raw_of(ordinary(50))
    motion = _motion(raw)
    shared = _dense(motion)
    errors: dict[str, list[float]] = {"positions": [], "colours": [], "opacity logits": []}
    for time in TIMES:
        basis, got = _de_boor(min(max(time, 0.0), 1.0), CONTROLS), motion.moved(raw, time)
        now = {name: np.einsum("k,nkc->nc", basis, getattr(motion, name).astype(float)) for name in CURVES}
        means = raw.means + now["position_controls"] + shared @ now["node_controls"]
        logits = raw.opacity_logits + now["opacity_controls"][:, 0]
        pairs = (
            (got.means, means),
            (got.colors, raw.colors + now["color_controls"]),
            (got.opacity_logits, logits),
        )
        for apart, (one, exact) in zip(errors.values(), pairs, strict=True):
            apart.append(float(np.abs(one - exact).max() / np.abs(exact).max()))
    for name, apart in errors.items():
        yield Row(SPLINE, f"{name} of Gaussians that move", worst(apart), 1e-6, "of the largest")


def _dense(motion: SplineMotion) -> FloatArray:
    """(N, M) what each Gaussian has of each node."""
    whole = np.zeros((len(motion.node_indices), len(motion.node_controls)))
    np.add.at(whole, (np.arange(len(whole))[:, None], motion.node_indices), motion.node_weights)
    return whole


def _trained() -> Iterator[Row]:
    """20 steps of noisy gradients at random times, against Adam and smoothing in float64."""
    raw, rng = raw_of(ordinary(50)), np.random.default_rng(8)
    trainer = SplineTrainer(_motion(raw), _rates())
    exact = {name: _Curves(getattr(trainer.motion, name)) for name in CURVES}
    shared = _dense(trainer.motion)
    for iteration, time in enumerate(rng.uniform(0, 1, 20)):
        by, seen = noisy_gradients(raw, rng), rng.uniform(size=len(raw)) < 0.8
        by.means[~seen] = 0
        basis = _de_boor(time, CONTROLS)
        trainer.update(time, by, seen, iteration)
        by_nodes = shared.T @ by.means
        touched: NDArray[np.bool_] = np.any(by_nodes, axis=1)
        exact["position_controls"].step(by.means, basis, seen)
        exact["color_controls"].step(by.colors, basis, seen)
        exact["opacity_controls"].step(by.opacity_logits[:, None], basis, seen)
        exact["node_controls"].step(by_nodes, basis, touched)
    for name, curves in exact.items():
        error = float(np.abs(getattr(trainer.motion, name) - curves.values).max()) / RATE
        yield Row(SPLINE, f"20 training steps: {name}", error, 0.05, "steps")
        moments = trainer.state()[f"first.{name}"]
        error = float(np.abs(moments - curves.first).max() / np.abs(curves.first).max())
        yield Row(SPLINE, f"20 training steps: mean gradient of {name}", error, 1e-5, "of the largest")


def _rates() -> SplineRates:
    same, smoothing = Rate.constant(RATE), Rate.constant(SMOOTHING)
    return SplineRates(position=same, color=same, opacity=same, smoothing=smoothing)


class _Curves:
    """Adam on the four control values that count at a time, each of which counts its own steps."""

    def __init__(self, controls: NDArray[np.float32]) -> None:
        self.values = controls.astype(np.float64)
        self.first, self._second = np.zeros_like(self.values), np.zeros_like(self.values)
        self._steps = np.zeros(controls.shape[1], np.int64)

    def step(self, gradients: NDArray[np.floating], basis: FloatArray, seen: NDArray[np.bool_]) -> None:
        """One."""
        start = min(int(np.flatnonzero(basis)[0]), len(basis) - 4)
        for k in range(start, start + 4):
            self._steps[k] += 1
            by = basis[k] * gradients[seen]
            moments = self.first[seen, k], self._second[seen, k]
            now = exact_adam.moved(self.values[seen, k], by, moments, RATE, int(self._steps[k]))
            self.values[seen, k], self.first[seen, k], self._second[seen, k] = now
        for k in range(max(start, 1), min(start + 3, len(basis) - 2) + 1):
            middle = (self.values[seen, k - 1] + self.values[seen, k + 1]) / 2
            self.values[seen, k] += SMOOTHING * (middle - self.values[seen, k])


def nodes() -> Iterator[Row]:
    """Gaussians in the view, beside it, behind the camera and in its centre hold on to some node; those
    around them lie about where they are seen, or at the edge next to that."""
    odd = [[0, 0, 10], [1e9, 0, 10], [0, 1e9, 10], [0, 0, -10], [0, 0, 0], [np.nan, 0, 10], [-1e-9, 0, 1e-9]]
    means = np.concatenate([np.array(odd, np.float32), ordinary(50).means])
    columns, rows = 20, 16
    indices, weights = attach(means, CAMERA, (columns, rows))
    apart = float(np.abs(weights.sum(axis=1) - 1).max())
    outside = np.count_nonzero((indices < 0) | (indices >= columns * rows))
    yield Row("motion nodes", "weights of Gaussians anywhere sum to 1", apart, 1e-6, "of 1")
    yield Row("motion nodes", "nodes that do not exist", float(outside), 0, "nodes")
    where = np.stack([indices % columns, indices // columns], axis=2)
    middle = (where * weights[:, :, None].astype(np.float64)).sum(axis=1)
    off = float(np.abs(middle - _seen_at(means.astype(np.float64), columns, rows)).max())
    yield Row("motion nodes", "their mean place, off the Gaussian's", off, 1e-4, "cells")


def _seen_at(means: FloatArray, columns: int, rows: int) -> FloatArray:
    """(N, 2) in cells, held to the view; a place that is no number is that of the first pixel."""
    cells = np.zeros((len(means), 2))
    for row, mean in enumerate(means):
        x, y, z, _ = CAMERA.camera_from_world @ np.append(mean, 1.0)
        with np.errstate(all="ignore"):
            u, v = CAMERA.fx * np.divide(x, z) + CAMERA.cx, CAMERA.fy * np.divide(y, z) + CAMERA.cy
        for axis, (at, size, count) in enumerate(((u, CAMERA.width, columns), (v, CAMERA.height, rows))):
            cells[row, axis] = min(max(at / size, 0.0), 1.0) * (count - 1) if np.isfinite(at) else 0.0
    return cells
