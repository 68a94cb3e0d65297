"""A camera is placed by points that it sees, whatever a minority of them does; poses and points settle."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from renderer.camera import Camera
from renderer.poses.bundle import Bundle, adjusted, misfit
from renderer.poses.resection import by_chance, resected
from renderer.poses.rigid_motion import Seen, inverse, lifted, local, moved, projected

LENS = Camera.from_fov(60, 320, 256)
STEP = np.array([0.05, -0.08, 0.03, 0.1, -0.06, 0.08])


def points(kind="solid", count=120):
    rng = np.random.default_rng(3)
    where = rng.uniform([-0.4, -0.3, 0.8], [0.4, 0.3, 1.2], (count, 3))
    if kind == "plane":
        where[:, 2] = 1 + 0.2 * where[:, 0]
    return where


def seen_from(pose, where):
    return Seen(projected(LENS, local(pose, where)), np.full((len(where), 3), (2.0, 2.0, 50.0)))


@pytest.mark.parametrize("kind", ["solid", "plane"])
def test_a_pose_is_recovered_exactly_from_exact_points(kind):
    truth = moved(np.eye(4), STEP)
    found = resected(LENS, points(kind), seen_from(truth, points(kind)), [np.eye(4)])
    np.testing.assert_allclose(found.pose, truth, atol=1e-6)
    assert found.inliers.all()
    assert found.misfit < 1e-4


def test_points_that_moved_together_do_not_pull_the_pose():
    truth, where = moved(np.eye(4), STEP), points()
    astray = where[:, 0] > np.quantile(where[:, 0], 0.7)
    seen = seen_from(truth, where + astray[:, None] * (0.05, 0.02, -0.08))
    found = resected(LENS, where, seen, [np.eye(4)])
    np.testing.assert_allclose(found.pose, truth, atol=1e-3)
    assert not found.inliers[astray].any()
    assert found.inliers[~astray].all()


def test_a_far_camera_is_found_by_chance_although_a_third_is_confused():
    truth, where = moved(np.eye(4), 5 * STEP), points()
    seen = seen_from(truth, where)
    rng = np.random.default_rng(0)
    seen.measured[:40, :2] = rng.uniform(0, 250, (40, 2))
    tried = by_chance(LENS, where, seen)
    found = resected(LENS, where, seen, [np.eye(4), *tried])
    np.testing.assert_allclose(found.pose, truth, atol=1e-3)


def test_no_pose_follows_from_one_point_seen_many_times():
    where = np.repeat(points()[:1], 20, axis=0)
    assert all(np.isfinite(pose).all() for pose in by_chance(LENS, where, seen_from(np.eye(4), where)))
    assert np.isfinite(
        resected(LENS, where, seen_from(np.eye(4), where), [moved(np.eye(4), STEP)]).pose
    ).all()


def test_slopes_are_those_of_finite_differences():
    from renderer.poses.rigid_motion import motion_slopes, slopes

    places, small = local(moved(np.eye(4), STEP), points()), 1e-6
    told = slopes(LENS, places) @ motion_slopes(places)
    for axis in range(6):
        step = small * np.eye(6)[axis]
        off = projected(LENS, local(moved(np.eye(4), step), places))
        back = projected(LENS, local(moved(np.eye(4), -step), places))
        np.testing.assert_allclose(told[:, :, axis], (off - back) / (2 * small), atol=1e-4)


def bundle(noise):
    """Five views of 120 points, poses and points off by `noise`; each view misses a fifth of them."""
    rng, where = np.random.default_rng(1), points()
    poses = np.stack([moved(np.eye(4), share * STEP) for share in np.linspace(0, 1, 5)])
    views, ids = np.nonzero(rng.uniform(size=(5, len(where))) < 0.8)
    measured = np.stack(
        [projected(LENS, local(poses[v], where[i : i + 1]))[0] for v, i in zip(views, ids, strict=True)]
    )
    off = [poses[0], *(moved(pose, noise * rng.standard_normal(6)) for pose in poses[1:])]
    return poses, Bundle(
        lens=LENS,
        poses=np.stack(off),
        points=where + noise * rng.standard_normal(where.shape),
        views=views,
        seen_points=ids,
        seen=Seen(measured, np.full(measured.shape, (2.0, 2.0, 50.0))),
    )


def test_poses_and_points_settle_on_what_was_seen():
    truth, off = bundle(0.01)
    found = adjusted(off)
    assert np.abs(misfit(found)).max() < 1e-2
    np.testing.assert_allclose(found.poses, truth, atol=1e-4)
    np.testing.assert_array_equal(found.poses[0], off.poses[0])


def test_one_view_alone_stays():
    _, off = bundle(0.0)
    of_first = off.views == 0
    alone = replace(
        off, poses=off.poses[:1], views=off.views[of_first], seen_points=off.seen_points[of_first],
        seen=Seen(off.seen.measured[of_first], off.seen.weights[of_first]),
    )  # fmt: skip
    np.testing.assert_array_equal(adjusted(alone).poses, alone.poses)


def test_lifting_undoes_projecting_and_inverse_undoes_a_pose():
    pose = moved(np.eye(4), STEP)
    np.testing.assert_allclose(lifted(LENS, projected(LENS, points())), points(), atol=1e-12)
    np.testing.assert_allclose(pose @ inverse(pose), np.eye(4), atol=1e-12)
    assert cv2.Rodrigues(pose[:3, :3])[0][:, 0] == pytest.approx(STEP[:3])
