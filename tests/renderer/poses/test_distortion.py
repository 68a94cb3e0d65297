"""Radial distortion is told from tracks within what is stated, and claimed only where they tell it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.poses.bundle import Bundle, FocalGuess, adjusted, k1_pulls, misfit
from renderer.poses.distortion import CERTAIN, Distortion, distortion_of
from renderer.poses.from_motion import FOCAL_SPREAD, focused
from renderer.poses.growing import seen_at
from renderer.poses.parts import Lost
from renderer.poses.radial import bent, bent_slopes, straightened
from renderer.poses.rigid_motion import local, moved, projected, zoomed
from renderer.poses.tracks import Sight, Tracked

LENS = replace(Camera.from_fov(60, 320, 256), fy=290.0)
GUESS = FocalGuess(LENS.fx, FOCAL_SPREAD)
STEP = np.array([0.05, -0.08, 0.03, 0.2, -0.12, 0.06])
COUNT, FRAMES, NOISE = 200, 24, 0.15


def points(kind="solid"):
    where = np.random.default_rng(3).uniform([-0.5, -0.4, 0.8], [0.5, 0.4, 1.3], (COUNT, 3))
    if kind == "plane":
        where[:, 2] = 1 + 0.2 * where[:, 0]
    return where


def path(count, step=STEP):
    return np.stack([moved(np.eye(4), share * step) for share in np.sin(np.linspace(0, 2, count))])


def tracks(k1, seed=0, kind="solid", step=STEP, pulled=lambda frame: 0.0):
    """Every third frame is a keyframe."""
    rng, sights = np.random.default_rng(seed), []
    for frame, pose in enumerate(path(FRAMES, step)):
        there = local(pose, points(kind) + pulled(frame))
        seen = bent(LENS, projected(LENS, there), k1)[:, :2] + rng.normal(0, NOISE, (COUNT, 2))
        sights.append(Sight(frame, np.arange(COUNT), seen))
    return Tracked(tuple(sights), tuple(range(0, FRAMES, 3)), COUNT)


def told(tracked) -> Distortion | None:
    found = focused(LENS, [tracked], GUESS, lambda *_: None)
    return distortion_of(found.done, [tracked], GUESS)


def bundle_of(k1, views=6, noise=0.5):
    """Exact, but for points and lens that are a little off."""
    ids = np.tile(np.arange(COUNT), views)
    poses = path(views)
    there = local(np.repeat(poses, COUNT, axis=0), points()[ids])
    seen = bent(LENS, projected(LENS, there), k1)[:, :2]
    off = points() + 0.003 * np.random.default_rng(1).standard_normal((COUNT, 3))
    return Bundle(
        lens=zoomed(LENS, 0.05), poses=poses, points=off, views=np.repeat(np.arange(views), COUNT),
        seen_points=ids, seen=seen_at(seen, noise), focal=FocalGuess(LENS.fx, 1e4), k1_spread=1e4,
    )  # fmt: skip


@pytest.mark.parametrize("k1", [-0.3, 0.0, 0.2])
def test_slopes_are_those_of_what_a_lens_shows(k1):
    places, small = points() * [1.5, 1.2, 1.0], 1e-6
    by_place, by_lens = bent_slopes(LENS, places, k1)

    def shown(lens, where, bending):
        return bent(lens, projected(lens, where), bending)

    for axis in range(3):
        step = small * np.eye(3)[axis]
        change = (shown(LENS, places + step, k1) - shown(LENS, places - step, k1)) / (2 * small)
        np.testing.assert_allclose(by_place[:, :, axis], change, rtol=1e-6, atol=1e-5)
    zoom = (shown(zoomed(LENS, small), places, k1) - shown(zoomed(LENS, -small), places, k1)) / (2 * small)
    bend = (shown(LENS, places, k1 + small) - shown(LENS, places, k1 - small)) / (2 * small)
    np.testing.assert_allclose(by_lens[:, :, 0], zoom, rtol=1e-6, atol=1e-5)
    np.testing.assert_allclose(by_lens[:, :, 1], bend, rtol=1e-6, atol=1e-5)


@pytest.mark.parametrize("k1", [-0.3, 0.0, 0.2])
def test_what_is_bent_is_straightened_again(k1):
    seen = projected(LENS, points())[:, :2]
    np.testing.assert_allclose(straightened(LENS, bent(LENS, seen, k1), k1), seen, atol=1e-6)


@pytest.mark.parametrize("k1", [-0.2, 0.0])
def test_k1_and_the_focal_length_settle_on_exact_places(k1):
    found = bundle_of(k1)
    for _ in range(4):
        found = adjusted(found, enough=1e-12)
    assert np.abs(misfit(found)).max() < 1e-6
    assert found.k1 == pytest.approx(k1, abs=1e-6)
    assert found.lens.fx == pytest.approx(LENS.fx, rel=1e-6)


def test_how_measures_pull_k1_is_as_a_dense_solution_has_it():
    """All slopes by differences, all unknowns at once; the scale is held by one more equation."""
    few = adjusted(adjusted(bundle_of(-0.2, 4), enough=1e-12), enough=1e-12)
    points_of = few.seen_points < 30
    some = replace(
        few, points=few.points[:30], views=few.views[points_of], seen_points=few.seen_points[points_of],
        seen=seen_at(few.seen.measured[points_of, :2], 0.5),
    )  # fmt: skip

    def there(step):
        poses = np.stack([moved(*each) for each in zip(some.poses, step[:24].reshape(4, 6), strict=True)])
        place = some.points + step[24:114].reshape(30, 3)
        lens = zoomed(some.lens, step[114])
        return misfit(replace(some, poses=poses, points=place, lens=lens, k1=some.k1 + step[115]))

    small = 1e-6
    slope = np.stack(
        [(there(small * each) - there(-small * each)).ravel() / (-2 * small) for each in np.eye(116)], axis=1
    )
    dense = np.linalg.pinv(slope[:, 6:], rcond=1e-9)[-1]
    np.testing.assert_allclose(k1_pulls(some).ravel(), dense, rtol=1e-3, atol=1e-3 * np.abs(dense).max())


@pytest.mark.parametrize(("k1", "seed"), [(-0.1, 0), (-0.3, 2), (0.1, 3)])
def test_k1_is_recovered_within_what_is_stated(k1, seed):
    """And the focal length, which comes out up to 1.7 times as long without it."""
    found = told(tracks(k1, seed))
    assert found is not None
    assert found.is_certain
    assert abs(found.k1 - k1) < 3 * found.deviation
    assert found.deviation < 0.03
    assert found.lens.fx == pytest.approx(LENS.fx, rel=0.05)
    assert found.rigid > 0.95


@pytest.mark.parametrize("seed", range(2))
def test_none_is_claimed_of_a_lens_that_has_none(seed):
    found = told(tracks(0.0, seed))
    assert found is not None
    assert abs(found.k1) < 3 * found.deviation
    assert not found.is_certain


@pytest.mark.parametrize("k1", [0.0, -0.1])
def test_of_a_plane_nothing_false_is_claimed(k1):
    found = told(tracks(k1, kind="plane"))
    assert found is None or not found.is_certain or abs(found.k1 - k1) < CERTAIN * found.deviation


@pytest.mark.parametrize("k1", [0.0, -0.1])
def test_of_a_camera_that_only_turns_nothing_is_claimed(k1):
    try:
        found = told(tracks(k1, step=STEP * [1, 1, 1, 0, 0, 0]))
    except Lost:
        return
    assert found is None or not found.is_certain


def test_of_tissue_that_moves_nothing_is_claimed():
    alone = points()[:, 0] > np.quantile(points()[:, 0], 0.67)

    def pulled(frame):
        return alone[:, None] * np.sin(frame / 5) * (0.03, 0.06, -0.05)

    found = told(tracks(-0.2, pulled=pulled))
    assert found is not None
    assert found.rigid < 0.8
    assert not found.is_certain


@pytest.mark.parametrize(
    ("changed", "certain"),
    [({}, True), ({"k1": 0.03}, False), ({"deviation": 0.08}, False), ({"rigid": 0.8}, False)],
)
def test_what_may_be_used(changed, certain):
    assert replace(Distortion(-0.2, 0.01, LENS, 1.0), **changed).is_certain == certain
