"""Training from depth that is a guess, or from sparse points alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from renderer.clip import Clip, ClipError, Frame, SparsePoints
from renderer.rasterize.cpu import Rasterizer, render
from renderer.raw_gaussians import RawGaussians
from renderer.train.events import Finished
from renderer.train.frames import train_frame
from renderer.train.initialize import sampled, with_points
from renderer.train.losses import LossWeights, picture_loss
from renderer.train.training import train
from tests.renderer.sheet import SIZE, SMALL, moving_sheet

WEIGHTS = LossWeights(color=0.0, inverse_depth=1.0)


def tilted() -> tuple[RawGaussians, Frame]:
    """A sheet that is nearer on one side, and a frame whose measured depth is what it draws."""
    frame = moving_sheet().read_frame(0)
    raw = sampled([frame], SMALL)
    means = raw.means.copy()
    means[:, 2] += means[:, 0] * np.float32(0.3)
    raw = replace(raw, means=means)
    drawn = render(raw.splats(), frame.camera)
    return raw, replace(frame, depth=np.where(drawn.alpha > 0.6, drawn.depth, 0).astype(np.float32))


def depth_loss(raw: RawGaussians, frame: Frame) -> float:
    rasterizer = Rasterizer(*SIZE)
    rasterizer.forward(raw.splats(), frame.camera)
    return picture_loss(rasterizer, train_frame(frame), WEIGHTS, 50.0).loss


def test_a_guess_supervises_shape_and_neither_scale_nor_shift() -> None:
    raw, frame = tilted()
    assert frame.depth is not None
    known = frame.depth > 0
    inverse = np.where(known, 0.7 / np.where(known, frame.depth, 1) + 0.004, 1)
    other = np.where(known, 1 / inverse, 0).astype(np.float32)
    assert depth_loss(raw, replace(frame, depth=other)) > 0.1
    assert depth_loss(raw, replace(frame, depth=other, depth_is_guess=True)) < 1e-3
    bent = other * (1 + 0.1 * np.sin(np.arange(SIZE[1]) / 3)[:, None]).astype(np.float32)
    assert depth_loss(raw, replace(frame, depth=bent, depth_is_guess=True)) > 0.02


def without_depth(clip: Clip, points: SparsePoints | None) -> Clip:
    return replace(
        clip,
        read_frame=lambda index: replace(clip.read_frame(index), depth=None),
        has_depth=False,
        points=points,
    )


def sheet_points(count: int = 120) -> SparsePoints:
    frame = moving_sheet().read_frame(0)
    assert frame.depth is not None
    places = np.random.default_rng(0).integers(0, frame.depth.size, count)
    return SparsePoints(frame.camera.unproject(frame.depth).reshape(-1, 3)[places].astype(np.float64))


def test_sparse_points_are_where_gaussians_start_and_supervise_nothing() -> None:
    blind = without_depth(moving_sheet(), sheet_points())
    frame = blind.read_frame(0)
    (seed,) = with_points([frame], blind.points)
    assert seed.depth is not None
    assert np.abs(seed.depth[seed.depth > 0] - 50).max() < 0.5
    assert (seed.depth > 0).mean() > 0.5
    assert train_frame(frame).n_depths == 0
    *_, last = train(blind, replace(SMALL, iterations=30))
    assert isinstance(last, Finished)


def test_a_clip_without_any_depth_is_refused_with_a_way_out() -> None:
    with pytest.raises(ClipError, match="--depth brightness"):
        list(train(without_depth(moving_sheet(), None), SMALL))
