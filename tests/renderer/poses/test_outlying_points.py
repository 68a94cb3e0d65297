"""Points beside a surface are told from it by their depth in the views; what shows no surface keeps all."""

from __future__ import annotations

import numpy as np

from renderer.camera import Camera
from renderer.poses.outlying_points import outlying
from renderer.poses.rigid_motion import moved

LENS = Camera.from_fov(60, 320, 256)
POSES = np.stack([moved(np.eye(4), share * np.array([0, 0, 0, 5, 3, 0])) for share in np.linspace(0, 1, 5)])


def surface(count: int = 400) -> np.ndarray:
    """A fold: near on the left, a third farther on the right."""
    x, y = np.random.default_rng(0).uniform([-30, -25], [30, 25], (count, 2)).T
    return np.stack([x, y, np.where(x < 0, 90.0, 120.0)], axis=1)


def test_what_floats_far_before_or_lies_far_behind_is_told_from_a_fold() -> None:
    points = surface()
    points[:5] *= 0.2
    points[5:9] *= 4
    found = outlying(LENS, POSES, points)
    assert found[:9].all()
    assert not found[9:].any()


def test_points_that_few_views_show_together_are_kept() -> None:
    points = surface(8) * np.linspace(0.1, 5, 8)[:, None]
    assert not outlying(LENS, POSES, points).any()
    assert not outlying(LENS, POSES, -surface()).any()
