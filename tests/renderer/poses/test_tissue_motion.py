"""Motions of tissue and of the camera are told apart on points whose path is made up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.poses.alike import left_by_neighbours
from renderer.poses.deforming import Deforming, fitted
from renderer.poses.rigid_motion import Seen, local, moved, projected
from renderer.poses.rigid_share import _Field, _shared, _weighted, divided
from renderer.poses.tissue_motion import places_of, poses_by_motion
from renderer.poses.views import View
from tests.benchmarks.camera_poses import errors

LENS = Camera(285.0, 285.0, 160.0, 128.0, 320, 256)
FRAMES = 48
TIMES = np.arange(FRAMES) / FRAMES
PULL = np.sin(np.pi * TIMES) ** 2
BREATH = np.sin(2 * np.pi * 6 * TIMES)


def camera_path():
    """A circle of a sixth of the distance, as that of the phantom."""
    steps = [
        np.r_[0.02 * np.sin(turn), 0.05 * np.sin(turn), 0, 0.15 * np.sin(turn), 0.08 * np.cos(turn), 0]
        for turn in 2 * np.pi * TIMES
    ]
    return np.stack([moved(np.eye(4), step) for step in steps])


def scene(breath, noise=0.02):
    """Points on a relief: pulled in the middle, breathing by `breath` of the distance everywhere."""
    rng = np.random.default_rng(3)
    flat = rng.uniform((-0.6, -0.5), (0.6, 0.5), (300, 2))
    relief = 0.1 * np.sin(5 * flat[:, 0]) + 0.1 * np.cos(4 * flat[:, 1])
    rest = np.c_[flat, 1 + relief]
    bump = np.exp(-(flat**2).sum(axis=1) / (2 * 0.15**2))
    swell = 0.5 + 0.5 * np.exp(-((flat - 0.3) ** 2).sum(axis=1) / (2 * 0.5**2))
    shifts = np.stack(
        [bump[:, None] * (0.08, 0.03, -0.1), breath * swell[:, None] * (0.2, 0.3, -0.9)], axis=1
    )
    courses = np.stack([PULL, BREATH], axis=1)
    poses, views = camera_path(), []
    for at, pose in enumerate(poses):
        seen = projected(LENS, local(pose, rest + np.einsum("k,pki->pi", courses[at], shifts)))
        seen += rng.standard_normal(seen.shape) * (noise, noise, noise / LENS.fx)
        weights = np.broadcast_to([10.0, 10.0, 10 * LENS.fx], seen.shape)
        views.append(View(at, pose, np.arange(len(rest)), Seen(seen, weights), np.ones(len(rest), bool)))
    return rest, courses, shifts, views


def off(poses):
    true = [LENS.moved(pose) for pose in camera_path()]
    return errors([LENS.moved(pose) for pose in poses], true)


def misled(views, breath):
    """Poses that follow the breathing of the middle, as those do that take all tissue to be at rest."""
    back = moved(np.eye(4), np.r_[0.5 * breath, 0, 0, 0.1 * breath, 0.2 * breath, -0.7 * breath])
    step = back - np.eye(4)
    return [
        replace(view, pose=_turned(view.pose, course * step))
        for view, course in zip(views, BREATH, strict=True)
    ]


def _turned(pose, step):
    there = np.eye(4) + step
    u, _, vt = np.linalg.svd(there[:3, :3])
    there[:3, :3] = u @ vt
    return pose @ there


@pytest.mark.parametrize("breath", [0.0, 0.05], ids=["pulled", "breathing, too"])
def test_the_path_is_found_before_tissue_that_moves_as_the_camera_does_or_faster(breath):
    rest, _, _, views = scene(breath)
    started = misled(views, breath or 0.02)
    assert off([view.pose for view in started])[0] > 1
    found = poses_by_motion(LENS, started, rest)
    away, turned = off(found)
    assert away < 0.5
    assert turned < 0.5


def test_tissue_that_moves_in_no_few_ways_is_left_to_others():
    rest, _, _, views = scene(0.0)
    rng = np.random.default_rng(0)

    def shaken(view):
        measured = view.seen.measured + rng.standard_normal(view.seen.measured.shape) * (3, 3, 0.01)
        return replace(view, seen=replace(view.seen, measured=measured))

    assert poses_by_motion(LENS, [shaken(view) for view in views], rest) is None


def test_points_that_move_as_those_around_them_are_told_from_points_that_stray_alone():
    smooth = made_up()
    rng = np.random.default_rng(0)
    alone = replace(smooth, shifts=0.02 * rng.standard_normal(smooth.shifts.shape))
    told = projected(LENS, local(alone.poses[alone.frames], alone.places()))
    strayed = replace(alone, seen=replace(alone.seen, measured=told))
    assert left_by_neighbours(smooth) < 0.6
    assert left_by_neighbours(strayed) > 0.9


def test_too_few_frames_tell_no_motion():
    rest, _, _, views = scene(0.0)
    assert poses_by_motion(LENS, views[:12], rest) is None


def made_up(breath=0.05):
    rest, courses, shifts, views = scene(breath, noise=0.0)
    return Deforming(
        lens=LENS,
        poses=np.stack([view.pose for view in views]),
        courses=courses,
        rest=rest,
        shifts=shifts,
        held_to=np.zeros_like(shifts),
        frames=np.repeat(np.arange(FRAMES), len(rest)),
        points=np.tile(np.arange(len(rest)), FRAMES),
        seen=Seen(
            np.concatenate([view.seen.measured for view in views]), np.full((FRAMES * len(rest), 3), 10.0)
        ),
    )


def test_what_is_divided_is_seen_where_it_was():
    before = made_up(0.01)
    assert np.abs(before.apart()).max() < 1e-9
    after = divided(before)
    assert np.abs(after.apart()[:, :2]).max() < 0.1
    np.testing.assert_array_equal(after.held_to, after.shifts)


def test_tissue_at_rest_at_one_side_is_not_pushed_against_a_pull():
    before = made_up(0.0)
    from_pull = np.linalg.norm(before.rest[:, :2] - (-0.2, 0.0), axis=1)
    bump = np.exp(-(from_pull**2) / (2 * 0.3**2))
    noise = 2e-4 * np.random.default_rng(1).standard_normal(before.shifts.shape)
    pulled = np.stack([bump[:, None] * (0.08, 0.03, -0.1), np.zeros_like(before.rest)], axis=1) + noise
    assert off(divided(replace(before, shifts=pulled)).poses)[0] < 0.5


@pytest.mark.parametrize("bulging", [0.0, 1.0], ids=["one way", "that bulges"])
def test_tissue_that_is_pulled_tells_the_camera_though_little_of_it_rests(bulging):
    before = pulled(bulging)
    path = divided(before).poses
    assert off(path)[0] < 0.4
    elsewhere = np.array([[0.02, -0.03, 0.01, 0.02, 0.01, -0.03], np.zeros(6)])
    again = divided(_shared(before, elsewhere)).poses
    assert off(again)[0] < off(path)[0] + 0.1


def pulled(bulging):
    """By a large tool if tissue goes one way; aside as well, as by a smaller one, where it is `bulging`."""
    before = made_up(0.0)
    from_pull = before.rest - before.rest[np.argmin(np.linalg.norm(before.rest[:, :2] + (0.2, 0.0), axis=1))]
    size = 0.22 if bulging else 0.3
    bump = np.exp(-(from_pull[:, :2] ** 2).sum(axis=1) / (2 * size**2))
    force = np.array([0.08, 0.03, -0.1])
    aside = bulging * (from_pull @ force)[:, None] * from_pull / size**2
    noise = 2e-4 * np.random.default_rng(1).standard_normal(before.shifts.shape)
    shifts = np.stack([bump[:, None] * (force + aside), np.zeros_like(before.rest)], axis=1) + noise
    return replace(before, shifts=shifts)


def test_points_count_by_what_they_do_along_and_across_the_way_that_most_go():
    rng = np.random.default_rng(2)
    way = np.array([0.6, 0.0, -0.8])
    left = np.outer(np.r_[np.zeros(20), rng.uniform(1, 3, 60)], way) + 1e-3 * rng.standard_normal((80, 3))
    counts = _Field(left, left, np.ones(80), np.ones(80), 1e-3).counts(0.1)
    along, in_all = np.einsum("pij,i,j->p", counts, way, way), np.trace(counts, axis1=1, axis2=2)
    assert np.linalg.eigvalsh(counts).min() > -1e-9
    np.testing.assert_allclose(along[:20], 1, atol=0.01)
    np.testing.assert_allclose(in_all[:20], 3, atol=0.01)
    np.testing.assert_allclose(along[20:], 0, atol=0.01)
    np.testing.assert_allclose(in_all[20:], 2, atol=0.05)


def test_the_rigid_motion_is_the_one_by_which_each_direction_counts_as_told():
    rng = np.random.default_rng(4)
    turns, shifts, half = (
        rng.standard_normal((30, 3, 6)),
        rng.standard_normal((30, 3)),
        rng.random((30, 3, 3)),
    )
    rows = np.concatenate([each @ turn for each, turn in zip(half, turns, strict=True)])
    values = np.concatenate([each @ shift for each, shift in zip(half, shifts, strict=True)])
    literal = -np.linalg.lstsq(rows, values, rcond=None)[0]
    np.testing.assert_allclose(_weighted(turns, shifts, half.swapaxes(1, 2) @ half), literal, atol=1e-8)


def test_fitted_finds_points_and_frames_again():
    true = made_up()
    rng = np.random.default_rng(1)
    disturbed = replace(
        true,
        rest=true.rest + 0.01 * rng.standard_normal(true.rest.shape),
        courses=true.courses + 0.05 * rng.standard_normal(true.courses.shape),
        held_to=true.shifts,
    )
    assert np.abs(fitted(disturbed, 20).apart()[:, :2]).max() < 0.2
    held = fitted(replace(true, courses=disturbed.courses), 20, points_stay=True)
    assert np.abs(held.apart()[:, :2]).max() < 0.2
    np.testing.assert_array_equal(held.rest, true.rest)


def test_places_are_the_mean_of_what_was_measured():
    rest, _, _, views = scene(0.0, noise=0.0)
    np.testing.assert_allclose(places_of(LENS, views[:1], np.zeros_like(rest)), rest, atol=1e-9)
    blind = [replace(views[0], seen=Seen(views[0].seen.measured, np.zeros((len(rest), 3))))]
    np.testing.assert_array_equal(places_of(LENS, blind, rest), rest)
