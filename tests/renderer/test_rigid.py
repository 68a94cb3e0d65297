"""A rigid motion is found again, also among points that move otherwise."""

from __future__ import annotations

import numpy as np
import pytest

from renderer.rigid import rigid_fit
from tests.renderer.scenes import turned_camera

MOTION = turned_camera(10, 10).camera_from_world


def cloud(count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-30, 30, (count, 3)) + np.array([0, 0, 60])


@pytest.mark.parametrize("count", [3, 4, 100])
def test_an_exact_motion_is_found(count):
    points = cloud(count)
    rotation, shift = rigid_fit(points, points @ MOTION[:3, :3].T + MOTION[:3, 3])
    np.testing.assert_allclose(rotation, MOTION[:3, :3], atol=1e-9)
    np.testing.assert_allclose(shift, MOTION[:3, 3], atol=1e-7)


def test_points_at_rest_stay():
    rotation, shift = rigid_fit(cloud(50), cloud(50))
    np.testing.assert_allclose(rotation, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(shift, 0, atol=1e-10)


def test_a_minority_that_moves_otherwise_has_no_say():
    points = cloud(200)
    moved = points @ MOTION[:3, :3].T + MOTION[:3, 3] + np.random.default_rng(1).normal(0, 0.05, (200, 3))
    moved[:60] += [25, 10, -5]
    rotation, shift = rigid_fit(points, moved)
    plain = np.linalg.norm(points[60:] @ rotation.T + shift - moved[60:], axis=1)
    assert np.median(plain) < 0.1


def test_a_mirror_is_no_rotation():
    points = cloud(50)
    rotation, _ = rigid_fit(points, points * [1, 1, -1])
    assert np.linalg.det(rotation) == pytest.approx(1)
