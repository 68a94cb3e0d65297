"""Motion-aware point fusion, and the whole method on a small scene."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.clip import ClipError, Frame
from renderer.deformation.fdm import FlexibleMotion
from renderer.train.checkpoint import checkpoint_paths
from renderer.train.config import TrainConfig
from renderer.train.fusion import OF_OTHERS, OF_REFERENCE, fused, reliable, restless
from renderer.train.training import train
from tests.renderer.sheet import finished, moving_sheet, same_bytes

CAMERA = Camera(60.0, 60.0, 40.0, 32.0, 80, 64)
MANY = TrainConfig(method="deform3dgs", n_gaussians=100_000)


def flat(index: int, level: int, depth: float, camera: Camera = CAMERA) -> Frame:
    """A grey wall, all of it tissue."""
    image = np.full((64, 80, 3), level, np.uint8)
    tissue = np.ones((64, 80), bool)
    return Frame(index, index / 10, image, camera, tissue, tissue, np.full((64, 80), depth, np.float32))


def behind_tool(frame: Frame, rows: slice, columns: slice) -> Frame:
    """The same with a tool before it, that hides its depth too."""
    tissue, image = frame.tissue_mask.copy(), frame.image.copy()
    tissue[rows, columns], image[rows, columns] = False, 255
    assert frame.depth is not None
    return replace(frame, tissue_mask=tissue, image=image, depth=np.where(tissue, frame.depth, 30.0))


def level_of(colors: np.ndarray) -> np.ndarray:
    return np.rint(colors[:, 0] * 255).astype(int)


def test_points_lie_on_the_tissue_behind_pixel_centres_and_none_twice() -> None:
    frame = behind_tool(flat(0, 100, 50.0), slice(0, 20), slice(0, 80))
    raw = fused([frame], MANY)
    pixels, depth = CAMERA.project(raw.means.astype(np.float64))
    assert np.allclose(depth, 50.0)
    assert np.abs(pixels - np.floor(pixels) - 0.5).max() < 1e-3
    cells = {tuple(pixel) for pixel in np.floor(pixels).astype(int).tolist()}
    assert cells == {(x, y) for x in range(80) for y in range(20, 64)}
    assert len(raw) == len(cells)


def test_balls_reach_to_their_neighbours_at_a_tenth_of_opacity() -> None:
    raw = fused([flat(0, 100, 60.0)], MANY)
    assert np.median(np.exp(raw.log_scales)) == pytest.approx(1.0, rel=1e-3)  # A pixel at this depth.
    assert np.allclose(raw.splats().opacities, 0.1)
    assert (raw.quats == (1, 0, 0, 0)).all()


def test_holes_behind_tools_are_filled_by_a_frame_that_sees_them_and_nothing_else_is() -> None:
    reference = behind_tool(flat(0, 100, 50.0), slice(10, 40), slice(10, 60))
    later = [flat(1, 100, 51.0), flat(2, 100, 52.0)]
    raw = fused([reference, *later], MANY)
    filling = raw.means[:, 2] > 50.5
    pixels, _ = CAMERA.project(raw.means[filling].astype(np.float64))
    assert (pixels > (10, 10)).all()
    assert (pixels < (60, 40)).all()
    assert set(np.unique(raw.means[filling, 2])) == {51.0}  # The first one filled it all.
    assert np.count_nonzero(filling) == 0.1 * 30 * 50


def test_moving_tissue_is_taken_from_every_frame() -> None:
    frames = [flat(0, 100, 50.0), flat(1, 100, 51.0), flat(2, 100, 52.0), flat(3, 100, 53.0)]
    rng = np.random.default_rng(0)
    for frame in frames:
        frame.image[:] += rng.integers(0, 3, frame.image.shape, dtype=np.uint8)
        frame.image[20:30, 20:30] = 40 if frame.index == 0 else 140
    moving = np.count_nonzero(restless(frames, frames[0]))
    raw = fused(frames, MANY)
    counts = [np.count_nonzero(raw.means[:, 2] == 50 + index) for index in range(4)]
    assert 100 <= moving < 0.05 * 64 * 80
    assert counts == [64 * 80, *[round(0.1 * moving)] * 3]
    patch = level_of(raw.colors[raw.means[:, 2] > 50]) == 140
    assert np.count_nonzero(patch) >= 0.4 * len(patch)


def test_a_moved_camera_fills_what_the_reference_lacks_where_it_lies_in_the_reference() -> None:
    """The camera slides along a wall by 8 pixels: the hole is elsewhere in its own picture."""
    reference = behind_tool(flat(0, 100, 60.0), slice(10, 40), slice(30, 50))
    pose = np.eye(4)
    pose[0, 3] = -8.0
    raw = fused([reference, flat(1, 120, 60.0, CAMERA.moved(pose))], MANY)
    filling = level_of(raw.colors) == 120
    pixels, _ = CAMERA.project(raw.means[filling].astype(np.float64))
    assert np.count_nonzero(filling) == 0.1 * 30 * 20
    assert (pixels > (30, 10)).all()
    assert (pixels < (50, 40)).all()


def test_unknown_and_outlying_depth_is_never_taken() -> None:
    frame = flat(0, 100, 50.0)
    assert frame.depth is not None
    frame.depth[:] += np.linspace(-1, 1, frame.depth.size, dtype=np.float32).reshape(64, 80)
    frame.depth[0, 0], frame.depth[1, 1], frame.depth[5:9] = 1.0, 400.0, 0.0
    for percentiles in (OF_REFERENCE, OF_OTHERS):
        mask = reliable(frame, percentiles)
        assert not mask[0, 0]
        assert not mask[1, 1]
        assert not mask[5:9].any()
        assert 0.88 < mask.mean() < 1
    assert fused([frame], MANY).means[:, 2].max() < 52


def test_restless_pixels_are_the_few_that_differ_most_from_the_mean() -> None:
    rng = np.random.default_rng(0)
    frames = [flat(index, 100, 50.0) for index in range(10)]
    for frame in frames:
        frame.image[:] += rng.integers(0, 3, frame.image.shape, dtype=np.uint8)
        frame.image[10:20, 10:20] += np.uint8(40 * (frame.index % 2))
    moving = restless(frames, frames[0])
    assert moving[10:20, 10:20].all()
    assert moving.mean() < 0.06
    assert not restless(frames[:1], frames[0]).any()


def test_seed_decides_which_points() -> None:
    frames = [moving_sheet().read_frame(index) for index in (0, 2, 3)]
    few = replace(MANY, n_gaussians=300)
    first, again, other = (fused(frames, config) for config in (few, few, replace(few, seed=1)))
    assert len(first) == 300
    assert np.array_equal(first.means, again.means)
    assert not np.array_equal(first.means, other.means)


def test_a_clip_without_depth_is_refused() -> None:
    with pytest.raises(ClipError, match="depth"):
        fused([replace(flat(0, 100, 50.0), depth=None)], MANY)


SMALL = TrainConfig(method="deform3dgs", iterations=400, n_gaussians=500, checkpoint_every=100, hold_out=True)


SLOW = moving_sheet(shift=1.0)
"""It hardly slides: the published rates are for slow motion."""


def test_moving_tissue_is_recovered_better_than_a_static_model_could() -> None:
    _, moving = finished(SLOW, SMALL)
    _, static = finished(SLOW, replace(SMALL, method="static"))
    assert moving > static + 1


def test_bumps_come_and_go_with_their_gaussians() -> None:
    """Past the first time of density control; pictures are as good as before it, soon after."""
    few, before = finished(SLOW, SMALL)
    many, after = finished(SLOW, replace(SMALL, iterations=650))
    assert isinstance(many.motion, FlexibleMotion)
    assert len(many) > len(few) == SMALL.n_gaussians
    assert many.motion.bumps.shape[1] == len(many)
    assert after > before - 1


def test_units_do_not_matter() -> None:
    """Metres or millimetres: the same picture quality from the same settings."""
    _, millimetres = finished(SLOW, SMALL)
    _, metres = finished(moving_sheet(1e-3, shift=1.0), SMALL)
    assert metres == pytest.approx(millimetres, abs=0.3)


def test_resumed_run_equals_the_uninterrupted_one(tmp_path: Path) -> None:
    clip, config = moving_sheet(), replace(SMALL, iterations=120, checkpoint_every=50)
    whole, _ = finished(clip, config)
    for _ in train(clip, config, folder=tmp_path):
        if checkpoint_paths(tmp_path):
            break
    resumed, _ = finished(clip, config, folder=tmp_path, resume=True)
    assert same_bytes(whole, resumed)
