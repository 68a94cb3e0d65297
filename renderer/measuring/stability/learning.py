"""Adam, density control and initialisation where there is next to nothing, or far too much."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from renderer.clip import ClipError, Frame
from renderer.measuring.stability import exact_adam
from renderer.measuring.stability.losses import SHAPE, frame
from renderer.measuring.stability.row import Row, worst
from renderer.measuring.stability.scenes import CAMERA, ordinary, raw_of
from renderer.raw_gaussians import RawGaussians
from renderer.train.adam import corrected_rate, update_rows
from renderer.train.config import TrainConfig
from renderer.train.densify import Densifier, DensityControl, Plan
from renderer.train.guards import hold_scales, leave_out_broken
from renderer.train.initialize import sampled, scene_size

FloatArray = NDArray[np.float64]
SIZE: Final = 10.0
"""Of the scene."""
DONE: Final = 600
"""Steps, when density is controlled."""
NO_DEPTH: Final = "reconstruction expects measured depth on the tissue, and {}"


def adam() -> Iterator[Row]:
    """200 steps of noisy gradients of one size, against float64, in steps of full length."""
    hazard, steps, rate = "Adam", 200, 1e-3
    for size in (0.0, 1e-30, 1e-16, 1e-8, 1.0, 1e8, 1e18, 1e20):
        gradients = size * (1 + np.random.default_rng(0).normal(size=(steps, 25, 2)))
        given = gradients.astype(np.float32)
        values, first, second = (np.zeros((25, 2), np.float32) for _ in range(3))
        seen = np.ones(25, bool)
        exact, *moments = (np.zeros((25, 2)) for _ in range(3))
        for step, gradient in enumerate(given, 1):
            update_rows(values, gradient, first, second, seen, corrected_rate(rate, step))
            wide, (m, v) = gradient.astype(np.float64), moments
            exact, *moments = exact_adam.moved(exact, wide, (m, v), rate, step)
        apart = float(np.abs(values - exact).max()) / rate
        done = "training leaves out gradients whose square overflows, and says so" if size > 1.8e19 else ""
        yield Row(hazard, f"gradients of {size:g}", apart, 0.05, "steps", done)
    yield Row(hazard, "gradients of NaN and 1e20: rows not left out, or others that are", _kept(), 0, "rows",
              "left out of the step, counted, and said at the end")  # fmt: skip
    log_scales = np.linspace(-30, 30, 90, dtype=np.float32).reshape(30, 3)
    held = np.clip(log_scales.astype(np.float64), np.log(1e-7 * SIZE), np.log(SIZE))
    beyond = np.count_nonzero(held != log_scales)
    missed = abs(hold_scales(log_scales, SIZE) - beyond)
    error = float(np.abs(log_scales - held).max()) if missed == 0 else np.inf
    yield Row("scales that run away", "held at 1e-7 and 1 of the scene size", error, 1e-5, "of the logarithm",
              "held, counted, and said at the end")  # fmt: skip


def _kept() -> float:
    """Of four Gaussians, of which the last is not seen, the two in the middle have broken gradients."""
    by = raw_of(ordinary(4))
    by.means[1, 2], by.quats[2, 1] = np.nan, 1e20
    seen = np.array([True, True, True, False])
    lost = leave_out_broken(by, seen)
    return float(abs(lost - 2) + np.count_nonzero(seen != [True, False, False, False]))


def density() -> Iterator[Row]:
    """Which Gaussians stay, repeat or go, where the new ones are, and how large."""
    hazard, raw = "density control", raw_of(ordinary(200))
    plain, faint = replace(raw, opacity_logits=0 * raw.opacity_logits), raw.opacity_logits - 90
    large = 0 * raw.log_scales + np.float32(18.4)
    cases: dict[str, tuple[RawGaussians, float, DensityControl]] = {
        "every one asks, all are split": (plain, 1.0, DensityControl()),
        "every one asks, the larger are split": (plain, 1.0, DensityControl(split_above=0.03)),
        "half of them ask": (plain, 2e-4, DensityControl()),
        "none asks": (plain, 0.0, DensityControl()),
        "slopes of 1e30": (plain, 1e30, DensityControl()),
        "no room for more": (plain, 1.0, DensityControl(most=10)),
        "some are faint": (replace(raw, opacity_logits=raw.opacity_logits - 5), 1.0, DensityControl()),
        "all are faint": (replace(raw, opacity_logits=faint), 1.0, DensityControl()),
        "scales of 1e8": (replace(plain, log_scales=large), 1.0, DensityControl()),
        "q = 0": (replace(plain, quats=0 * raw.quats), 1.0, DensityControl()),
    }
    for name, (model, asks, control) in cases.items():
        control_of = Densifier(control, SIZE, len(model))
        sums = asks * np.linspace(0.5, 1.5, len(model), dtype=np.float32)
        counts = np.ones(len(model), np.int32)
        control_of.restore({"density.sums": sums, "density.counts": counts})
        plan = control_of.plan(model, DONE)
        yield Row(hazard, name, _plan_off(plan, model, sums, control), 1e-5, "of their scale")
    yield Row(hazard, "lengths of slopes by the centres", _lengths_off(), 1e-6, "of themselves")


def _plan_off(plan: Plan, raw: RawGaussians, sums: NDArray[np.float32], control: DensityControl) -> float:
    """Of places and log-scales; without bound where other Gaussians stay or repeat than should."""
    scales = np.exp(raw.log_scales.astype(np.float64))
    stays = 1 / (1 + np.exp(-raw.opacity_logits.astype(np.float64))) >= control.min_opacity
    asks = stays & (sums >= control.gradient)
    if np.count_nonzero(stays) + np.count_nonzero(asks) > control.most:
        asks[:] = False
    split = asks & (scales.max(axis=1) > control.split_above * SIZE)
    children = np.flatnonzero(split).repeat(2)
    old = np.flatnonzero(stays & ~split)
    index = np.concatenate([old, np.flatnonzero(asks & ~split), children])
    fresh = np.arange(len(index)) >= len(old)
    if not (np.array_equal(plan.index, index) and np.array_equal(plan.fresh, fresh)):
        return np.inf
    means, log_scales = raw.means[index].astype(np.float64), raw.log_scales[index].astype(np.float64)
    noise = np.random.default_rng([control.seed, DONE]).standard_normal((len(children), 3))
    turns = np.stack([_rotation(quat) for quat in raw.quats[children].astype(np.float64)] or [np.eye(3)])
    first = len(index) - len(children)
    means[first:] += np.einsum("nij,nj->ni", turns[: len(children)], noise * scales[children])
    log_scales[first:] -= np.log(1.6)
    apart = np.abs(plan.means - means) / np.maximum(scales[index].max(axis=1, keepdims=True), np.abs(means))
    return worst([*apart.ravel(), *np.abs(plan.log_scales - log_scales).ravel() / 20])


def _rotation(quat: FloatArray) -> FloatArray:
    """(3, 3) of wxyz, by what it does to the axes: q v q*."""
    length = np.linalg.norm(quat)
    if length == 0:
        return np.eye(3)
    w, along = quat[0] / length, quat[1:] / length
    axes = np.eye(3)
    across = np.cross(along, axes)
    turned = (w * w - along @ along) * axes + 2 * np.outer(axes @ along, along) + 2 * w * across
    return np.asarray(turned.T)


def _lengths_off() -> float:
    """After two steps, of which each saw some."""
    gathered, rng = Densifier(DensityControl(), SIZE, 50), np.random.default_rng(2)
    lengths, counts = np.zeros(50), np.zeros(50, np.int32)
    for _ in range(2):
        by, seen = rng.normal(size=(50, 2)).astype(np.float32), rng.uniform(size=50) < 0.7
        gathered.add(by, seen, CAMERA)
        lengths[seen] += np.hypot(by[seen, 0] * CAMERA.width / 2, by[seen, 1] * CAMERA.height / 2)
        counts[seen] += 1
    state = gathered.state()
    if not np.array_equal(state["density.counts"], counts):
        return np.inf
    return float(np.abs(state["density.sums"] - lengths).max() / lengths.max())


def initialisation() -> Iterator[Row]:
    """Gaussians lie behind the middles of their pixels, at their depth, in their colour, of their size."""
    hazard, config = "initialisation", TrainConfig(n_gaussians=5000)
    usual = frame()
    assert usual.depth is not None
    pixel, far, half = np.zeros(SHAPE, np.float32), usual.depth.copy(), usual.depth.copy()
    pixel[4, 5], far[0, 0], half[:, ::2] = 10.0, 1e30, 0.0
    slope = np.linspace(8, 12, usual.depth.size, dtype=np.float32).reshape(SHAPE)
    frames = {
        "one frame of one depth, more Gaussians than pixels": usual,
        "a slope": replace(usual, depth=slope),
        "one pixel with depth": replace(usual, depth=pixel),
        "depth in every second column": replace(usual, depth=half),
        "one depth of 1e30 among others": replace(usual, depth=far),
        "depths of 1e-30": frame(1e-30),
        "depths of 1e30": frame(1e30),
    }
    for name, given in frames.items():
        error = _seeds_off(sampled([given], config), given, config)
        yield Row(hazard, name, error, 1e-5, "pixels, or of themselves")
    small, large = (sampled([frame(depth)], config) for depth in (10.0, 1e-2))
    apart = np.abs(1e-3 * small.means - large.means).max() / 1e-2
    yield Row(hazard, "millimetres and metres give the same", float(apart), 1e-6, "of the depth")
    masked = replace(usual, tissue_mask=np.zeros(SHAPE, bool))
    empty = {
        "depth all 0": (frame(0.0), "this clip has none"),
        "empty mask": (masked, "its masks leave out all of it"),
    }
    for name, (given, why) in empty.items():
        accepted = float(not _refuses(partial(scene_size, [given]), NO_DEPTH.format(why)))
        done = "refused in one line: measured depth on the tissue is expected"
        yield Row(hazard, f"{name}: not refused", accepted, 0, "cases", done)


def _seeds_off(raw: RawGaussians, given: Frame, config: TrainConfig) -> float:
    """Of places in pixels; of depths, colours and standard deviations; infinite where pixels are missed.

    Where no depth is measured, or one at the ends of its range, any within that range will do.
    """
    assert given.depth is not None
    count = np.count_nonzero(given.tissue_mask)
    x, y, z = raw.means.astype(np.float64).T
    u, v = CAMERA.fx * x / z + CAMERA.cx, CAMERA.fy * y / z + CAMERA.cy
    columns, rows = (
        np.clip(np.floor(at), 0, size - 1).astype(int) for at, size in ((u, SHAPE[1]), (v, SHAPE[0]))
    )
    if len(raw) != count or len(np.unique(rows * SHAPE[1] + columns)) != count:
        return np.inf
    low, high = np.percentile(given.depth[given.depth_mask].astype(np.float64), (0.1, 99.9))
    depths = given.depth[rows, columns].astype(np.float64)
    depths = np.where((depths >= low) & (depths <= high), depths, np.clip(z, low, high))
    colors = given.image[rows, columns] / 255
    scales = config.initial_spacing * depths / CAMERA.fx
    logit = np.log(config.initial_opacity / (1 - config.initial_opacity))
    errors = [u - columns - 0.5, v - rows - 0.5, z / depths - 1, raw.opacity_logits - logit]
    errors += [*(raw.colors - colors).T, *(raw.log_scales - np.log(scales)[:, None]).T / 100]
    errors += [*(raw.quats - np.array([1, 0, 0, 0])).T]
    return worst(np.abs(errors).ravel())


def _refuses(work: Callable[[], object], line: str) -> bool:
    """In that line."""
    try:
        work()
    except ClipError as refusal:
        return line in str(refusal)
    return False
