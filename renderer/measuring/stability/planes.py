"""What moves Gaussians by planes over space and time (HexPlane) and small heads, and its training."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from renderer.deformation.heads import Heads
from renderer.deformation.hexplane import LANES, Layout, lines_at, sample, time_taps, within_box
from renderer.deformation.hexplane_motion import HexplaneMotion
from renderer.measuring.stability.row import Row, worst
from renderer.measuring.stability.scenes import noisy_gradients, ordinary, raw_of
from renderer.raw_gaussians import RawGaussians
from renderer.stored_arrays import Arrays
from renderer.train.hexplane_trainer import FIXED, HexplaneRates, HexplaneTrainer
from renderer.train.rates import Rate

FloatArray = NDArray[np.float64]
Values = dict[str, FloatArray]
PLANES, HEADS = "planes in space and time", "heads of the planes"
TIMES = (0.0, 1e-9, 0.1, 0.5, 1 - 1e-9, 1.0, -3.0, 3.0)
"""The last two lie outside a clip and are those of its ends."""
CELL_RATE, HEAD_RATE = 1e-2, 1e-3
STEP = 1e-6
"""Of the differences that slopes are."""


def features() -> Iterator[Row]:
    """Of points on and beyond the box."""
    rows = [time_taps(time, 25)[0] for time in TIMES]
    outside = float(sum(row < 0 or row > 23 for row in rows))
    yield Row(PLANES, "rows of time that do not exist", outside, 0, "rows")
    resolutions = np.array([[9, 7, 2], [64, 48, 16]], np.int32)
    layout, rng = Layout.of(resolutions), np.random.default_rng(2)
    planes = rng.normal(size=(1, layout.n_plane_cells, LANES)).astype(np.float32)
    times = rng.normal(size=(25, 1, layout.n_line_cells, LANES)).astype(np.float32)
    means, shares = rng.uniform(-5, 5, (200, 3)).astype(np.float32), []
    boxes = {
        "within the box": np.array([[-5, -5, -5], [5, 5, 5]], np.float32),
        "on the edges of the box": np.array([means.min(axis=0), means.max(axis=0)], np.float32),
        "far beyond the box": np.array([[-1e-3] * 3, [1e-3] * 3], np.float32),
        "a box without depth": np.array([[-5, -5, 0], [5, 5, 0]], np.float32),
        "a box of one point": np.zeros((2, 3), np.float32),
        "a box of 1e30": np.array([[-1e30] * 3, [1e30] * 3], np.float32),
    }
    for name, box in boxes.items():
        points, errors = within_box(means, box), []
        wanted = exact_features(planes, times, resolutions, points.astype(np.float64), TIMES)
        largest = max(1.0, float(np.abs(wanted).max()))
        shares.append(float(np.abs(points - _shares(means.astype(np.float64), box)).max()))
        for time, exact in zip(TIMES, wanted, strict=True):
            got = np.empty((len(points), len(resolutions) * LANES), np.float32)
            lines = lines_at(times, time)
            sample(planes, lines, layout.resolutions, layout.planes, layout.lines, points, got)
            errors.append(float(np.abs(got - exact).max()) / largest)
        yield Row(PLANES, name, worst(errors), 1e-5, "of the largest")
    yield Row(PLANES, "where points lie in each box", worst(shares), 1e-6, "of the box")


def _shares(means: FloatArray, box: NDArray[np.float32]) -> FloatArray:
    """(N, 3) in a box, one side of which may be 0."""
    low, high = box.astype(np.float64)
    return np.asarray(np.clip((means - low) / np.where(high > low, high - low, 1.0), 0, 1))


def exact_features(
    planes: NDArray[np.floating],  # (B, plane cells, LANES)
    times: NDArray[np.floating],  # (T, B, line cells, LANES)
    resolutions: NDArray[np.int32],
    points: FloatArray,  # (N, 3) in [0, 1]
    moments: Sequence[float],
) -> FloatArray:
    """(moments, N, L B LANES) by the definition: products of hat functions' sums, on six planes a level."""
    lines = np.einsum("mt,tblc->mblc", _hats(np.array(moments), len(times)), times.astype(np.float64))
    levels = []
    at_plane = at_line = 0
    for counts in resolutions:
        hats = [_hats(points[:, axis], int(count)) for axis, count in enumerate(counts)]
        level = np.ones((len(moments), len(points), len(planes), LANES))
        for across, down in ((0, 1), (0, 2), (1, 2)):
            cells = int(counts[across] * counts[down])
            part = planes[:, at_plane : at_plane + cells].astype(np.float64)
            part = part.reshape(len(planes), counts[down], counts[across], LANES)
            level *= np.einsum("nj,ni,bjic->nbc", hats[down], hats[across], part, optimize=True)
            at_plane += cells
        for axis, count in enumerate(counts):
            level *= np.einsum(
                "ni,mbic->mnbc", hats[axis], lines[:, :, at_line : at_line + count], optimize=True
            )
            at_line += count
        levels.append(level.reshape(len(moments), len(points), -1))
    return np.concatenate(levels, axis=2)


def _hats(shares: FloatArray, count: int) -> FloatArray:
    """(N, count) weights of evenly spaced values at shares of the way, held to both ends."""
    places = np.clip(shares, 0, 1)[:, None] * (count - 1)
    return np.asarray(np.clip(1 - np.abs(places - np.arange(count)), 0, None))


def moves() -> Iterator[Row]:
    """Offsets of Gaussians; gradients by all arrays, and where the first step of training goes."""
    raw, rng, time = raw_of(ordinary(70)), np.random.default_rng(9), 0.37
    motion = _motion(raw, rng)
    now = {name: value.astype(np.float64) for name, value in motion.arrays().items()}
    rates = HexplaneRates(cells=Rate.constant(CELL_RATE), heads=Rate.constant(HEAD_RATE))
    trainer, before = HexplaneTrainer(motion, rates), _copied(motion.arrays())
    moved, exact = trainer.moved(raw, time), _offsets(now, raw, time)
    pairs = (
        (moved.means, raw.means, exact[:, :3]),
        (moved.log_scales, raw.log_scales, exact[:, 3:6]),
        (moved.quats, raw.quats, exact[:, 6:]),
    )
    errors = [float(np.abs(got - rest - offset).max()) for got, rest, offset in pairs]
    yield Row(
        HEADS, "offsets of Gaussians", worst(errors) / float(np.abs(exact).max()), 1e-5, "of the largest"
    )
    by, seen = noisy_gradients(raw, rng), rng.uniform(size=len(raw)) < 0.8
    trainer.update(time, by, seen, 0)
    found = {name: trainer.state()[f"first.{name}"] / 0.1 for name in now if name not in FIXED}
    for name, slope in found.items():
        error = _off(name, slope.astype(np.float64), now, (raw, by, seen, time))
        yield Row(HEADS, f"gradient by {name}", error, 1e-4, "of itself")
    yield from _first_step(before, trainer.motion.arrays(), found)


def _motion(raw: RawGaussians, rng: np.random.Generator) -> HexplaneMotion:
    """Random, in a box that leaves some Gaussians outside."""
    resolutions = np.array([[9, 7, 5], [16, 12, 8]], np.int32)
    layout = Layout.of(resolutions)
    return HexplaneMotion(
        box=np.float32(0.9) * np.stack([raw.means.min(axis=0), raw.means.max(axis=0)]),
        unit=np.array([1.5], np.float32),
        resolutions=resolutions,
        plane_cells=rng.uniform(0.5, 1.5, (1, layout.n_plane_cells, LANES)).astype(np.float32),
        time_cells=rng.uniform(0.5, 1.5, (6, 1, layout.n_line_cells, LANES)).astype(np.float32),
        heads=Heads.random(len(resolutions) * LANES, rng),
    )


def _copied(arrays: Arrays) -> Arrays:
    return {name: value.copy() for name, value in arrays.items()}


def _offsets(now: Values, raw: RawGaussians, time: float) -> FloatArray:
    """(N, 10) of position, log-scale and quaternion, layer by layer."""
    points = _shares(raw.means.astype(np.float64), now["box"].astype(np.float32))
    resolutions = now["resolutions"].astype(np.int32)
    cells = exact_features(now["plane_cells"], now["time_cells"], resolutions, points, [time])[0]
    trunk = np.maximum(cells @ now["trunk_weight"] + now["trunk_bias"], 0)
    hidden = np.maximum(trunk @ now["hidden_weight"] + now["hidden_bias"], 0)
    columns = []
    for head, (first, last) in enumerate(pairwise((0, 3, 6, 10))):
        width = hidden.shape[1] // 3
        own = hidden[:, head * width : (head + 1) * width]
        columns.append(own @ now["output_weight"][:, first:last])
    offsets = np.concatenate(columns, axis=1) + now["output_bias"]
    offsets[:, :3] *= now["unit"]
    return np.asarray(offsets)


def _loss(now: Values, raw: RawGaussians, by: RawGaussians, seen: NDArray[np.bool_], time: float) -> float:
    """What has these gradients by the Gaussians that move."""
    slopes = np.concatenate([by.means, by.log_scales, by.quats], axis=1)
    return float((_offsets(now, raw, time) * slopes)[seen].sum())


def _off(
    name: str,
    found: FloatArray,
    now: Values,
    given: tuple[RawGaussians, RawGaussians, NDArray[np.bool_], float],
) -> float:
    """Along four random ways, against differences of the loss; of the steepest."""
    raw, by, seen, time = given
    rng, apart, slopes = np.random.default_rng(10), [], []
    for _ in range(4):
        way = rng.normal(size=found.shape)
        sides = (_loss(now | {name: now[name] + step * way}, raw, by, seen, time) for step in (STEP, -STEP))
        more, less = sides
        slopes.append((more - less) / (2 * STEP))
        apart.append(abs(float((found * way).sum()) - slopes[-1]))
    return worst(apart) / worst(abs(slope) for slope in slopes)


def _first_step(before: Arrays, after: Arrays, found: Arrays) -> Iterator[Row]:
    """Adam's first is of the rate's length, down the gradient; of rows in time longer, as they rest."""
    cells = {"plane_cells": CELL_RATE, "time_cells": CELL_RATE * 3**0.5}
    for name, slope in found.items():
        change = (after[name].astype(np.float64) - before[name]) / cells.get(name, HEAD_RATE)
        error = float(np.abs(change + np.sign(slope)).max())
        yield Row(HEADS, f"first training step: {name}", error, 1e-2, "steps")
