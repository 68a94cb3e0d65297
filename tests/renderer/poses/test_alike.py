"""Motions of tissue are told from drift of tracks by whether neighbours share them, on points made up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from renderer.poses.alike import by_size, shared_motions, told_by_depth
from renderer.poses.deforming import Deforming
from renderer.poses.rigid_motion import Seen, local, projected
from renderer.poses.tissue_motion import poses_by_motion
from renderer.poses.views import View
from tests.renderer.poses.test_tissue_motion import FRAMES, LENS, PULL, TIMES, camera_path, off

LATER = np.sin(np.pi * np.clip((TIMES - 0.45) / 0.55, 0, 1)) ** 2
"""A pull in the second half of the clip."""


def found_in(courses, second, own, in_image=0.0, in_depth=0.0):
    """As if two motions had been found: a pull in the middle, and at one side another of the size `second` of
    that, to which each point adds as much as `own` (standard deviation) for itself, as where tracks drift.
    What is seen fits them but for noise in px and in inverse depth."""
    rng = np.random.default_rng(5)
    flat = rng.uniform((-0.6, -0.5), (0.6, 0.5), (300, 2))
    rest = np.c_[flat, 1 + 0.1 * np.sin(5 * flat[:, 0]) + 0.1 * np.cos(4 * flat[:, 1])]
    bumps = [
        np.exp(-((flat - at) ** 2).sum(axis=1) / (2 * 0.2**2))[:, None] for at in ((-0.1, 0.0), (0.3, 0.1))
    ]
    shifts = np.stack([bumps[0] * (0.08, 0.03, -0.1), second * bumps[1] * (-0.06, 0.05, -0.09)], axis=1)
    shifts[:, 1] += own * rng.standard_normal(rest.shape)
    none = np.zeros((FRAMES * len(rest), 3))
    now = Deforming(
        lens=LENS, poses=camera_path(), courses=courses, rest=rest, shifts=shifts, held_to=shifts,
        frames=np.repeat(np.arange(FRAMES), len(rest)), points=np.tile(np.arange(len(rest)), FRAMES),
        seen=Seen(none, none + 1),
    )  # fmt: skip
    measured = projected(LENS, local(now.poses[now.frames], now.places()))
    noise = rng.standard_normal(measured.shape) * (in_image, in_image, in_depth)
    return replace(now, seen=replace(now.seen, measured=measured + noise))


def left_of(course, now):
    """Share of a course that those of the motions and a constant do not tell."""
    told = np.c_[now.courses, np.ones(FRAMES)]
    left = course - told @ np.linalg.lstsq(told, course, rcond=None)[0]
    return np.linalg.norm(left) / np.linalg.norm(course - course.mean())


def test_a_motion_that_each_point_has_to_itself_is_not_the_tissues():
    now = shared_motions(by_size(found_in(np.c_[PULL, TIMES], 0.0, own=0.01)))
    assert now.courses.shape[1] == now.shifts.shape[1] == now.held_to.shape[1] == 1
    assert left_of(PULL, now) < 0.05


@pytest.mark.parametrize("second", [1.0, 0.5])
def test_two_slow_pulls_at_two_places_are_both_kept(second):
    before = found_in(np.c_[PULL, LATER], second, own=0.003)
    now = shared_motions(by_size(before))
    assert now.courses.shape[1] == 2
    np.testing.assert_allclose(now.places(), before.places(), atol=1e-9)
    assert np.abs(now.courses.mean(axis=0)).max() < 1e-9


def test_depth_that_is_exact_tells_of_a_motion_of_each_point():
    courses = np.c_[PULL, TIMES]
    assert told_by_depth(by_size(found_in(courses, 0.0, own=0.01, in_depth=1e-4)))
    assert not told_by_depth(by_size(found_in(courses, 0.0, own=0.01, in_depth=0.02)))
    assert told_by_depth(by_size(found_in(courses, 1.0, own=0.0, in_depth=1e-4)))


def test_one_motion_alone_stays():
    two = found_in(np.c_[PULL, TIMES], 0.0, own=0.0)
    one = replace(two, courses=two.courses[:, :1], shifts=two.shifts[:, :1], held_to=two.shifts[:, :1])
    assert shared_motions(by_size(one)).courses.shape[1] == 1


def drifting(seed, lasting=20, count=500):
    """Points that are pulled, and what frames show of each for a while: its track goes at random along the
    tissue, some farther than others; depth is that of where it is, off by 1.6 %."""
    rng = np.random.default_rng(seed)
    flat = rng.uniform((-0.6, -0.5), (0.6, 0.5), (count, 2))
    drift = np.cumsum(rng.standard_normal((FRAMES, *flat.shape)), axis=0)
    drift -= drift.mean(axis=0)
    drift *= 0.4 / LENS.fx / drift.std() * np.exp(0.7 * rng.standard_normal((count, 1)))
    begins = rng.integers(1 - lasting // 2, FRAMES - lasting // 2, count)
    views = []
    for frame, pose in enumerate(camera_path()):
        places = pulled(flat + drift[frame], PULL[frame])
        seen = projected(LENS, local(pose, places)) + rng.standard_normal(places.shape) * (0.05, 0.05, 0.016)
        ids = np.flatnonzero((begins <= frame) & (frame < begins + lasting))
        weights = np.broadcast_to([10.0, 10.0, 10 * LENS.fx], seen[ids].shape)
        views.append(View(frame, pose, ids, Seen(seen[ids], weights), np.ones(len(ids), bool)))
    return pulled(flat, 0.0), views


def pulled(flat, by):
    bump = np.exp(-((flat - (-0.1, 0.0)) ** 2).sum(axis=1) / (2 * 0.2**2))[:, None]
    relief = 0.1 * np.sin(5 * flat[:, 0]) + 0.1 * np.cos(4 * flat[:, 1])
    return np.c_[flat, 1 + relief] + by * bump * (0.08, 0.03, -0.1)


def test_tracks_that_drift_take_little_of_the_path_along():
    errors = []
    for seed in (10, 11):
        rest, views = drifting(seed)
        errors.append(off(poses_by_motion(LENS, views, rest)))
    away, turned = np.mean(errors, axis=0)
    assert away < 0.8
    assert turned < 0.3
