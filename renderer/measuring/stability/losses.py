"""Training losses and their slopes where there is next to nothing, or far too much, against float64."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from renderer.clip import Frame
from renderer.measuring.stability.exact_loss import ExactLoss
from renderer.measuring.stability.row import Row, worst
from renderer.measuring.stability.scenes import CAMERA, NEAR, ordinary
from renderer.rasterize.cpu import Rasterizer
from renderer.rasterize.tiles import (
    BY_BLUE,
    BY_DEPTH,
    BY_RED,
    BY_WEIGHT,
    LEFT,
    PLANE_BLUE,
    PLANE_DEPTH,
    PLANE_RED,
    TOTAL,
)
from renderer.train.frames import TrainFrame, train_frame
from renderer.train.losses import LossWeights, picture_loss

FloatArray = NDArray[np.float64]
HAZARD: Final = "training loss"
SHAPE: Final = (CAMERA.height, CAMERA.width)
SIZE: Final = 10.0
COLOR_AND_DEPTH: Final = LossWeights(depth=0.2)
EVERY_TERM: Final = LossWeights(
    opacity=0.3,
    depth=0.2,
    inverse_depth=0.1,
    image_variation=0.1,
    inverse_depth_variation=0.1,
)
WAYS: Final = 4


def frame(depth: float = 10.0) -> Frame:
    """A frame of noise, all tissue at one depth; 0: none measured."""
    image = np.random.default_rng(0).integers(0, 256, (*SHAPE, 3), dtype=np.uint8)
    everywhere = np.ones(SHAPE, bool)
    return Frame(0, 0.0, image, CAMERA, everywhere, everywhere, np.full(SHAPE, depth, np.float32))


def rows() -> Iterator[Row]:
    """The loss and its slopes along random ways."""
    whole, nothing = frame(), np.zeros(SHAPE, bool)
    one, half = nothing.copy(), nothing.copy()
    one[9, 9] = True
    half[:, 13:] = True
    cases = {
        "colour and depth": (whole, COLOR_AND_DEPTH),
        "depth all 0: colour alone": (frame(0.0), COLOR_AND_DEPTH),
        "every term": (whole, EVERY_TERM),
        "every term, empty mask": (replace(whole, tissue_mask=nothing), EVERY_TERM),
        "every term, half a mask": (replace(whole, tissue_mask=half), EVERY_TERM),
        "every term, one pixel": (replace(whole, tissue_mask=one), EVERY_TERM),
        "every term, depth of 1e-30": (frame(1e-30), EVERY_TERM),
        "every term, depth of 1e30": (frame(1e30), EVERY_TERM),
        "every term, black frame": (replace(whole, image=np.zeros_like(whole.image)), EVERY_TERM),
        "every term, white frame": (replace(whole, image=np.full_like(whole.image, 255)), EVERY_TERM),
    }
    for name, (given, weights) in cases.items():
        yield from _of(name, given, given.tissue_mask, weights, 200)
    hidden, seen = replace(whole, tissue_mask=half), half.copy()
    seen[:, 5:] = True
    yield from _of("every term, tissue behind a tool", hidden, seen, EVERY_TERM, 200)
    yield from _of("every term, nothing drawn", whole, whole.tissue_mask, EVERY_TERM, 0)
    got, by, _ = _loss(train_frame(replace(whole, tissue_mask=nothing), ~nothing), COLOR_AND_DEPTH, 200)
    yield Row(HAZARD, "empty mask", abs(got) + float(np.abs(by).sum()), 0, "loss and slopes")


def _of(name: str, given: Frame, seen: NDArray[np.bool_], weights: LossWeights, splats: int) -> Iterator[Row]:
    """`seen` (H, W) is where some frame shows tissue; the rest was never seen."""
    ready, inside = train_frame(given, ~seen, seen), np.s_[: SHAPE[0], : SHAPE[1]]
    got, by, planes = _loss(ready, weights, splats)
    exact = ExactLoss(given, weights, SIZE, ready.opaque[inside], ready.unseen[inside])
    wanted = exact.value(planes)
    yield Row(HAZARD, name, abs(got - wanted) / wanted, 1e-5, "of itself")
    yield Row(HAZARD, f"{name}: slopes", _slopes_off(by, planes, exact), 1e-4, "of the steepest")


def _loss(ready: TrainFrame, weights: LossWeights, count: int) -> tuple[float, FloatArray, FloatArray]:
    """As trained: the loss, its adjoint and the planes that it is of, without padding."""
    rasterizer = Rasterizer(CAMERA.width, CAMERA.height)
    rasterizer.forward(ordinary(count), CAMERA, NEAR)
    with warnings.catch_warnings():
        # Depths of 1e30 have no square.
        warnings.simplefilter("ignore", RuntimeWarning)
        got = picture_loss(rasterizer, ready, weights, SIZE).loss
    inside = slice(SHAPE[0]), slice(SHAPE[1])
    by, planes = (each[:, *inside].astype(np.float64) for each in (rasterizer.adjoint, rasterizer.planes))
    return got, by, planes


def _slopes_off(by: FloatArray, planes: FloatArray, exact: ExactLoss) -> float:
    """Along random ways of all planes, and of what the adjoint says of their total."""
    rng, apart, slopes = np.random.default_rng(6), [], []
    for _ in range(WAYS):
        way = rng.normal(size=planes.shape)
        way[PLANE_DEPTH] *= SIZE
        slopes.append(exact.slope(planes, way))
        found = (by[BY_RED : BY_BLUE + 1] * way[PLANE_RED : PLANE_BLUE + 1]).sum()
        found += (by[BY_DEPTH] * way[PLANE_DEPTH]).sum() - (by[BY_WEIGHT] * way[LEFT]).sum()
        apart.append(abs(float(found) - slopes[-1]))
    parts = [*(by[BY_RED : BY_BLUE + 1] * planes[PLANE_RED : PLANE_BLUE + 1])]
    parts += [by[BY_DEPTH] * planes[PLANE_DEPTH], by[BY_WEIGHT] * (1 - planes[LEFT])]
    total = np.abs(by[TOTAL] - sum(parts)).max() / max(float(np.abs(parts).max()), 1e-300)
    return worst([worst(apart) / worst(abs(slope) for slope in slopes), float(total)])
