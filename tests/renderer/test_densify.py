"""Density control: what asks for more Gaussians, and what becomes of a model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.rasterize.cpu import Rasterizer
from renderer.raw_gaussians import RawGaussians
from renderer.train.densify import SHRINK, Densifier, DensityControl
from renderer.train.frames import TrainFrame, train_frame
from renderer.train.losses import LossWeights, picture_loss
from renderer.train.methods import recipe_for
from renderer.train.model import TrainModel
from tests.renderer.sheet import SMALL, moving_sheet, needs_of

CAMERA = Camera(50.0, 50.0, 24.0, 16.0, 48, 32)


def blobs(count: int, seed: int = 0) -> RawGaussians:
    rng = np.random.default_rng(seed)
    means = np.column_stack([rng.uniform(-15, 15, count), rng.uniform(-10, 10, count), np.full(count, 50.0)])
    return RawGaussians(
        means=means.astype(np.float32),
        quats=rng.normal(size=(count, 4)).astype(np.float32),
        log_scales=np.log(rng.uniform(0.5, 4, (count, 3))).astype(np.float32),
        opacity_logits=rng.uniform(-4, 4, count).astype(np.float32),
        colors=rng.uniform(0, 1, (count, 3)).astype(np.float32),
        harmonics=np.zeros((count, 0, 3), np.float32),
    )


def loss_of(raw: RawGaussians, camera: Camera, frame: TrainFrame) -> tuple[float, Rasterizer]:
    rasterizer, splats = Rasterizer(camera.width, camera.height), raw.splats()
    rasterizer.forward(splats, camera)
    loss = picture_loss(rasterizer, frame, LossWeights(), 50.0).loss
    rasterizer.backward(splats)
    return loss, rasterizer


def test_gathered_length_is_the_slope_by_the_centre_on_screen() -> None:
    """Of a single splat, moving its centre is moving the principal point."""
    frame = train_frame(moving_sheet().read_frame(0))
    raw = replace(blobs(1), means=np.float32([[0.3, -0.2, 50]]), log_scales=np.full((1, 3), 3.4, np.float32))
    density = Densifier(DensityControl(), 50.0, 1)
    rasterizer = loss_of(raw, CAMERA, frame)[1]
    density.add(rasterizer.by_centers(), rasterizer.visible, CAMERA)
    step = 0.02
    slopes = []
    for name in ("cx", "cy"):
        ahead, behind = (
            loss_of(raw, replace(CAMERA, **{name: getattr(CAMERA, name) + sign * step}), frame)[0]
            for sign in (1, -1)
        )
        slopes.append((ahead - behind) / (2 * step))
    expected = np.hypot(slopes[0] * 24, slopes[1] * 16)
    assert density.state()["density.sums"][0] == pytest.approx(expected, rel=0.02)


def planned(raw: RawGaussians, asks: np.ndarray, **control: float) -> tuple[Densifier, RawGaussians]:
    density = Densifier(DensityControl(**control), 50.0, len(raw))  # type: ignore[arg-type]
    density.restore({"density.sums": asks.astype(np.float32), "density.counts": np.ones(len(raw), np.int32)})
    return density, raw


def test_faint_ones_go_large_ones_split_and_small_ones_are_cloned() -> None:
    raw = blobs(60)
    asks = np.zeros(60)
    asks[::3] = 1.0
    density, _ = planned(raw, asks, split_above=2.5 / 50)
    raw = replace(raw, opacity_logits=np.where(np.arange(60) < 5, -9, raw.opacity_logits).astype(np.float32))
    plan = density.plan(raw, 600)
    faint = np.arange(60) < 5
    large = np.exp(raw.log_scales.max(axis=1)) > 2.5
    asked = (asks > 0) & ~faint
    times = np.bincount(plan.index, minlength=60)
    assert (times[faint] == 0).all()
    assert (times[asked] == 2).all()
    assert (times[~asked & ~faint] == 1).all()
    assert np.count_nonzero(asked & large) > 0 < np.count_nonzero(asked & ~large)
    for n in np.flatnonzero(asked):
        mine = plan.index == n
        shrunk = np.allclose(plan.log_scales[mine], raw.log_scales[n] - np.log(SHRINK), atol=1e-6)
        same = np.array_equal(plan.means[mine], raw.means[[n, n]])
        assert (shrunk, same) == ((True, False) if large[n] else (False, True))
        assert plan.fresh[mine].sum() == (2 if large[n] else 1)


def test_children_are_drawn_from_their_parent() -> None:
    """Mean and covariance of many children are the parent's R S S R^T."""
    count = 20_000
    one = blobs(1, seed=5)
    raw = replace(one.rows(np.zeros(count, np.int64)), opacity_logits=np.full(count, 2.0, np.float32))
    density, _ = planned(raw, np.ones(count))
    plan = density.plan(raw, 600)
    offsets = plan.means - raw.means[0]
    w, x, y, z = one.quats[0].astype(float) / np.linalg.norm(one.quats[0])
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    expected = rotation @ np.diag(np.exp(2 * one.log_scales[0].astype(float))) @ rotation.T
    assert np.allclose(np.cov(offsets.T), expected, atol=0.04 * np.trace(expected))
    assert np.abs(offsets.mean(axis=0)).max() < 0.05


def test_plans_repeat_and_stop_at_the_most() -> None:
    raw = blobs(40)
    density, _ = planned(raw, np.ones(40))
    assert np.array_equal(density.plan(raw, 600).means, density.plan(raw, 600).means)
    assert not np.array_equal(density.plan(raw, 600).means, density.plan(raw, 700).means)
    full, _ = planned(raw, np.ones(40), most=45)
    assert len(full.plan(raw, 600).index) <= 40


def test_a_model_grows_learns_and_goes_on_from_its_state() -> None:
    """Far beyond the first changes nothing collapses, and a restored model takes the same steps."""
    clip = moving_sheet()
    frames = [clip.read_frame(index) for index in (0, 2, 3)]
    views = [train_frame(frame) for frame in frames]
    config = replace(SMALL, n_gaussians=150, iterations=400)
    plain = recipe_for(config, needs_of(clip, config))
    recipe = replace(plain, density=DensityControl(start=40, every=20, gradient=1e-3, most=600))

    def fresh() -> TrainModel:
        raw = recipe.initialize(frames)
        return TrainModel(raw, recipe.make_trainer(raw, frames, 50.0), recipe, 50.0)

    model, losses = fresh(), []
    for iteration in range(200):
        losses.append(model.step(views[iteration % 3], iteration).loss)
    assert 150 < len(model) <= 600
    assert np.mean(losses[-30:]) < 0.8 * np.mean(losses[:30])
    other = fresh()
    other.restore(model.state())
    for iteration in range(200, 250):
        for one in (model, other):
            one.step(views[iteration % 3], iteration)
    for name, value in model.state().items():
        assert np.array_equal(value, other.state()[name]), name


@pytest.mark.parametrize("every_moment", [False, True])
def test_gaussians_out_of_view_do_not_count_as_seen(every_moment: bool) -> None:
    """Also where their moments move them on."""
    clip = moving_sheet()
    frames = [clip.read_frame(index) for index in (0, 2)]
    config = replace(SMALL, n_gaussians=150)
    plain = recipe_for(config, needs_of(clip, config))
    recipe = replace(plain, density=DensityControl(start=500), every_moment=every_moment)
    raw = recipe.initialize(frames)
    raw.means[7, 2] = -50
    model = TrainModel(raw, recipe.make_trainer(raw, frames, 50.0), recipe, 50.0)
    for iteration, frame in enumerate(frames):
        model.step(train_frame(frame), iteration)
    counts = model.state()["density.counts"]
    assert counts[7] == 0
    assert counts.max() == 2
