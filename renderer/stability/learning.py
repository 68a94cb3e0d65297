"""Losses, Adam, density control and initialisation where there is next to nothing, or far too much."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from renderer.clip import ClipError, Frame
from renderer.rasterize.cpu import BLACK, Rasterizer
from renderer.raw_gaussians import RawGaussians
from renderer.stability.row import Row
from renderer.stability.scenes import CAMERA, NEAR, ordinary
from renderer.train.adam import BETA_1, BETA_2, EPSILON, corrected_rate, update_rows
from renderer.train.config import TrainConfig
from renderer.train.densify import Densifier, DensityControl
from renderer.train.frames import train_frame
from renderer.train.guards import leave_out_broken
from renderer.train.initialize import sampled, scene_size
from renderer.train.losses import LossWeights, picture_loss

SHAPE = CAMERA.height, CAMERA.width
EVERY_TERM = LossWeights(
    depth=0.2, inverse_depth=0.1, dissimilarity=0.2, image_variation=0.1, inverse_depth_variation=0.1
)
BROKEN = "broken values"


def rows() -> Iterator[Row]:
    """See the file."""
    yield from _losses()
    yield from _adam()
    yield from _density()
    yield from _initialisation()


def frame(depth: float = 10.0, seed: int = 0) -> Frame:
    """A photo of noise, all tissue at one depth; 0: none measured."""
    image = np.random.default_rng(seed).integers(0, 256, (*SHAPE, 3), dtype=np.uint8)
    everywhere = np.ones(SHAPE, bool)
    return Frame(0, 0.0, image, CAMERA, everywhere, everywhere, np.full(SHAPE, depth, np.float32))


def _losses() -> Iterator[Row]:
    hazard, whole = "training loss", frame()
    nothing = np.zeros(SHAPE, bool)
    one = nothing.copy()
    one[9, 9] = True
    got, wanted, _ = _loss(whole, LossWeights(depth=0.2))
    yield Row(hazard, "colour and depth", abs(got - wanted) / wanted, 1e-5, "of itself")
    got, wanted, _ = _loss(replace(whole, depth=np.zeros(SHAPE, np.float32)), LossWeights(depth=0.2))
    yield Row(hazard, "depth all 0: colour alone", abs(got - wanted) / wanted, 1e-5, "of itself")
    got, _, slopes = _loss(replace(whole, tissue_mask=nothing), LossWeights(depth=0.2, dissimilarity=0.2))
    yield Row(hazard, "empty mask", abs(got) + float(np.abs(slopes).sum()), 0, "loss and slopes")
    cases = {
        "every term": whole,
        "every term, empty mask": replace(whole, tissue_mask=nothing),
        "every term, one pixel": replace(whole, tissue_mask=one),
        "every term, depth of 1e-30": frame(1e-30),
        "every term, depth of 1e30": frame(1e30),
        "every term, black photo": replace(whole, image=np.zeros_like(whole.image)),
        "every term, white photo": replace(whole, image=np.full_like(whole.image, 255)),
    }
    for name, each in cases.items():
        got, _, slopes = _loss(each, EVERY_TERM)
        yield Row(hazard, name, float(not np.isfinite(got)) + _broken(slopes), 0, BROKEN)
    got, _, slopes = _loss(whole, EVERY_TERM, empty=True)
    yield Row(hazard, "every term, nothing drawn", float(not np.isfinite(got)) + _broken(slopes), 0, BROKEN)


def _loss(
    given: Frame, weights: LossWeights, empty: bool = False
) -> tuple[float, float, NDArray[np.float32]]:
    """As trained; literally in float64, of colour and depth; and the slopes."""
    splats = ordinary(0 if empty else 200)
    rasterizer, ready = Rasterizer(CAMERA.width, CAMERA.height), train_frame(given)
    rasterizer.forward(splats, CAMERA, NEAR)
    drawn = rasterizer.rendered(CAMERA.width, CAMERA.height, BLACK)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        got = picture_loss(rasterizer, ready, weights, 10.0).loss
    mask, known = given.tissue_mask, given.depth_mask
    color = np.abs(drawn.image.astype(np.float64) - given.image / 255.0)[mask].sum() / max(1, 3 * mask.sum())
    assert given.depth is not None
    seen = known & (drawn.alpha > 0.5)
    apart = np.abs(drawn.depth.astype(np.float64) - given.depth)[seen].sum() / (max(1, known.sum()) * 10.0)
    return got, float(color + weights.depth * apart), rasterizer.adjoint


def _adam() -> Iterator[Row]:
    """200 steps of noisy gradients of one size, against float64, in steps of full length."""
    hazard, steps, rate = "Adam", 200, 1e-3
    for size in (0.0, 1e-30, 1e-16, 1e-8, 1.0, 1e8, 1e18, 1e20):
        gradients = size * (1 + np.random.default_rng(0).normal(size=(steps, 50, 1)))
        given = gradients.astype(np.float32)
        values, first, second = (np.zeros((50, 1), np.float32) for _ in range(3))
        seen = np.ones(50, bool)
        exact, m, v = (np.zeros((50, 1)) for _ in range(3))
        for step, gradient in enumerate(given):
            update_rows(values, gradient, first, second, seen, corrected_rate(rate, step + 1))
            g = gradient.astype(np.float64)
            m, v = BETA_1 * m + (1 - BETA_1) * g, BETA_2 * v + (1 - BETA_2) * g * g
            exact -= corrected_rate(rate, step + 1) * m / (np.sqrt(v) + EPSILON)
        apart = float(np.abs(values - exact).max()) / rate
        done = "training leaves out gradients whose square overflows, and says so" if size > 1.8e19 else ""
        yield Row(hazard, f"gradients of {size:g}", apart, 0.05, "steps", done)
    splats = ordinary(3)
    by = RawGaussians(
        means=splats.means, quats=splats.quats, log_scales=splats.scales, opacity_logits=splats.opacities,
        colors=splats.colors, harmonics=splats.harmonics,
    )  # fmt: skip
    by.means[1, 2] = np.nan
    by.quats[2, 1] = 1e20
    seen = np.ones(3, bool)
    lost = leave_out_broken(by, seen)
    missed = float(abs(lost - 2) + seen[1] + seen[2])
    done = "left out of the step, counted, and said at the end"
    yield Row(hazard, "gradients of NaN and 1e20: rows not left out", missed, 0, "rows", done)


def _density() -> Iterator[Row]:
    hazard, splats = "density control", ordinary(200)
    raw = RawGaussians(
        means=splats.means, quats=splats.quats, log_scales=np.log(splats.scales),
        opacity_logits=np.zeros(200, np.float32), colors=splats.colors, harmonics=splats.harmonics,
    )  # fmt: skip
    cases: dict[str, tuple[RawGaussians, float, DensityControl]] = {
        "every one asks, all are split": (raw, 1.0, DensityControl()),
        "none asks": (raw, 0.0, DensityControl()),
        "slopes of 1e30": (raw, 1e30, DensityControl()),
        "no room for more": (raw, 1.0, DensityControl(most=10)),
        "all are faint": (replace(raw, opacity_logits=raw.opacity_logits - 90), 1.0, DensityControl()),
        "scales of 1e8": (
            replace(raw, log_scales=0 * raw.log_scales + np.float32(18.4)),
            1.0,
            DensityControl(),
        ),
        "q = 0": (replace(raw, quats=0 * raw.quats), 1.0, DensityControl()),
    }
    for name, (model, asks, control) in cases.items():
        density = Densifier(control, 10.0, len(model))
        sums, counts = np.full(len(model), asks, np.float32), np.ones(len(model), np.int32)
        density.restore({"density.sums": sums, "density.counts": counts})
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            plan = density.plan(model, 600)
        worst = _broken(plan.means) + _broken(plan.log_scales) + max(0, len(plan.index) - control.most * 20)
        yield Row(hazard, name, worst, 0, BROKEN)


def _initialisation() -> Iterator[Row]:
    hazard, config = "initialisation", TrainConfig(n_gaussians=5000)
    usual = frame()
    assert usual.depth is not None
    pixel, far = np.zeros(SHAPE, np.float32), usual.depth.copy()
    pixel[4, 5], far[0, 0] = 10.0, 1e30
    frames = {
        "one frame of one depth, more Gaussians than pixels": usual,
        "one pixel with depth": replace(usual, depth=pixel),
        "one depth of 1e30 among others": replace(usual, depth=far),
        "depths of 1e-30": frame(1e-30),
        "depths of 1e30": frame(1e30),
    }
    for name, given in frames.items():
        raw = sampled([given], config)
        yield Row(hazard, name, sum(_broken(value) for value in raw.arrays().values()), 0, BROKEN)
    small, large = (sampled([frame(depth)], config) for depth in (10.0, 1e-2))
    apart = np.abs(1e-3 * small.means - large.means).max() / 1e-2
    yield Row(hazard, "millimetres and metres give the same", float(apart), 1e-6, "of the depth")
    empty = {"depth all 0": frame(0.0), "empty mask": replace(usual, tissue_mask=np.zeros(SHAPE, bool))}
    for name, given in empty.items():
        accepted = float(not _refuses(partial(scene_size, [given])))
        done = "refused in one line: measured depth on the tissue is expected"
        yield Row(hazard, f"{name}: not refused", accepted, 0, "cases", done)


def _refuses(work: Callable[[], object]) -> bool:
    try:
        work()
    except ClipError:
        return True
    return False


def _broken(values: NDArray[Any]) -> float:
    return float(np.count_nonzero(~np.isfinite(values)))
