"""Depth between sparse points: exact on planes, close on the phantom, none without points."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.clip import Frame
from renderer.depth.sparse_depth import depth_between
from renderer.phantom import Phantom, PhantomParams


@cache
def phantom_frame(seed: int) -> Frame:
    params = PhantomParams(n_frames=8, width=128, height=96, seed=seed, camera="moving")
    return Phantom(params).view(3).frame


def random_points(frame: Frame, count: int, noise: float = 0.0) -> np.ndarray:
    assert frame.depth is not None
    rng = np.random.default_rng(0)
    spread = np.exp(noise * rng.standard_normal(frame.depth.shape)).astype(np.float32)
    chosen = rng.choice(np.flatnonzero(frame.tissue_mask), count, replace=False)
    return frame.camera.unproject(frame.depth * spread).reshape(-1, 3)[chosen]


@pytest.mark.parametrize(("noise", "median", "largest"), [(0.0, 0.003, 0.05), (0.02, 0.015, 0.08)])
def test_two_hundred_points_give_the_phantom(noise, median, largest):
    for seed in (41, 42):
        frame = phantom_frame(seed)
        assert frame.depth is not None
        found = depth_between(random_points(frame, 200, noise), frame.camera, frame.tissue_mask)
        known = found > 0
        error = np.abs(found[known] / frame.depth[known] - 1)
        assert np.array_equal(known, frame.tissue_mask)
        assert np.median(error) < median
        assert np.percentile(error, 99) < largest


def test_a_plane_is_exact():
    camera = Camera(100, 110, 60, 40, 128, 96)
    columns, rows = np.meshgrid(np.arange(128) + 0.5, np.arange(96) + 0.5)
    depth = 1 / (0.02 + 1e-5 * columns - 2e-5 * rows)
    points = camera.unproject(depth)[5:90:9, 4:125:11].reshape(-1, 3)
    found = depth_between(points, camera, np.ones((96, 128), dtype=bool))
    spanned = np.s_[8:84, 8:110]
    np.testing.assert_allclose(found[spanned], depth[spanned], rtol=1e-4)


def test_tissue_beyond_the_points_gets_a_depth_in_their_range():
    """Better than the points' median, or Gaussians might as well start on a wall."""
    for seed in (41, 42):
        frame = phantom_frame(seed)
        assert frame.depth is not None
        near = frame.tissue_mask.copy()
        near[:, 80:] = False
        points, depths = frame.camera.unproject(frame.depth)[near][::25], frame.depth[near][::25]
        found = depth_between(points, frame.camera, frame.tissue_mask)
        assert np.array_equal(found > 0, frame.tissue_mask)
        assert depths.min() * 0.999 <= found[frame.tissue_mask].min()
        assert found.max() <= depths.max() * 1.001
        beyond = frame.tissue_mask & ~near
        truth = frame.depth[beyond]
        wall = np.median(np.abs(np.median(depths) / truth - 1))
        assert np.median(np.abs(found[beyond] / truth - 1)) < 0.7 * wall


def test_failed_matches_behind_and_beyond_do_not_matter():
    frame = phantom_frame(42)
    points = random_points(frame, 200)
    centre = frame.camera.position
    stray = np.concatenate([centre + 10 * (points[:9] - centre), centre - (points[9:18] - centre)])
    nowhere = np.full((3, 3), np.nan)
    found = depth_between(np.concatenate([points, stray, nowhere]), frame.camera, frame.tissue_mask)
    np.testing.assert_allclose(found, depth_between(points, frame.camera, frame.tissue_mask), rtol=1e-6)


def test_the_unit_does_not_matter():
    frame = phantom_frame(42)
    points, camera = random_points(frame, 200), frame.camera
    metres = camera.camera_from_world.copy()
    metres[:3, 3] /= 1000
    found = depth_between(points / 1000, camera.moved(metres), frame.tissue_mask)
    np.testing.assert_allclose(1000 * found, depth_between(points, camera, frame.tissue_mask), rtol=1e-5)


@pytest.mark.parametrize("count", [0, 1, 3])
def test_too_few_points_give_none(count):
    frame = phantom_frame(41)
    points = random_points(frame, 200)[:count]
    assert not depth_between(points, frame.camera, frame.tissue_mask).any()


def test_points_on_one_line_or_one_place_give_none():
    camera = Camera(100, 100, 64, 48, 128, 96)
    everywhere = np.ones((96, 128), dtype=bool)
    line = np.stack([np.linspace(-20, 20, 12), np.zeros(12), np.full(12, 50.0)], axis=1)
    assert not depth_between(line, camera, everywhere).any()
    assert not depth_between(np.repeat(line[:1], 12, axis=0), camera, everywhere).any()
