"""Cameras and points without depth: exact where what is seen is exact; what tells none is refused by name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.poses import from_motion
from renderer.poses.bundle import Bundle, FocalGuess, adjusted, misfit
from renderer.poses.from_motion import FOCAL_SPREAD, MEDIAN_DEPTH, Solved, focused, solved
from renderer.poses.growing import seen_at
from renderer.poses.loop_closure import Closed
from renderer.poses.parts import Lost
from renderer.poses.rigid_motion import local, moved, projected, zoomed
from renderer.poses.settling import Noise, Settled
from renderer.poses.tracks import Sight, Tracked
from renderer.poses.triangulation import triangulated
from renderer.poses.two_views import parallax, second_poses

LENS = Camera.from_fov(60, 320, 256)
STEP = np.array([0.05, -0.08, 0.03, 0.2, -0.12, 0.06])
COUNT = 120


def points(kind="solid"):
    where = np.random.default_rng(3).uniform([-0.5, -0.4, 0.8], [0.5, 0.4, 1.3], (COUNT, 3))
    if kind == "plane":
        where[:, 2] = 1 + 0.2 * where[:, 0]
    return where


def path(count):
    """A camera that swings to the side and turns back to what it looks at."""
    shares = np.sin(np.linspace(0, 2, count))
    return np.stack([moved(np.eye(4), share * STEP) for share in shares])


def places_of(pose, where, lens=LENS):
    return projected(lens, local(pose, where))[:, :2]


def followed(poses, where=None, lens=LENS, shown=lambda frame: slice(None)):
    """Exact tracks; every third frame is a keyframe."""
    ids, sights = np.arange(COUNT), []
    for frame, pose in enumerate(poses):
        there = points() if where is None else where(frame)
        sights.append(Sight(frame, ids[shown(frame)], places_of(pose, there, lens)[shown(frame)]))
    return Tracked(tuple(sights), tuple(range(0, len(poses), 3)), COUNT)


def shape_of(poses):
    """Places of cameras from the first one, in units of the way between the first and the farthest."""
    back = np.linalg.inv(poses[0])
    places = np.stack([np.linalg.inv(pose @ back)[:3, 3] for pose in poses])
    return places / np.linalg.norm(places, axis=1).max()


@pytest.mark.parametrize("kind", ["solid", "plane"])
def test_two_views_give_the_pose_but_for_its_length(kind):
    """To what OpenCV's float32 holds."""
    truth = moved(np.eye(4), STEP)
    one, other = places_of(np.eye(4), points(kind)), places_of(truth, points(kind))
    truth[:3, 3] /= np.linalg.norm(truth[:3, 3])
    assert min(np.abs(pose - truth).max() for pose in second_poses(LENS, one, other)) < 1e-5


def test_a_turn_has_no_parallax_whatever_the_focal_length_and_a_shift_has():
    turned, shifted = moved(np.eye(4), STEP * [1, 1, 1, 0, 0, 0]), moved(np.eye(4), STEP)
    one = places_of(np.eye(4), points())
    assert parallax(LENS, one, places_of(turned, points()), True) < 1e-6
    assert parallax(zoomed(LENS, 0.25), one, places_of(turned, points()), False) < 1e-6
    assert parallax(LENS, one, places_of(shifted, points()), False) > 3


def test_points_are_triangulated_exactly():
    poses, ids = path(5), np.tile(np.arange(COUNT), 5)
    places = np.concatenate([places_of(pose, points()) for pose in poses])
    found = triangulated(LENS, np.repeat(poses, COUNT, axis=0), ids, places, COUNT)
    np.testing.assert_allclose(found.where, points(), atol=1e-8)
    assert found.misfit.max() < 1e-6
    assert found.angle.min() > 0.05


@pytest.mark.parametrize("way", [1.0, 0.2])
def test_how_far_depths_may_be_off_follows_from_misfit_and_parallax(way):
    """A fifth of the way of the camera makes them five times as uncertain."""
    rng = np.random.default_rng(2)
    poses, ids = [moved(np.eye(4), share * way * STEP) for share in np.linspace(0, 1, 6)], np.arange(COUNT)
    places = np.concatenate([places_of(pose, points()) for pose in poses])
    noisy = places + rng.normal(0, 0.3, places.shape)
    found = triangulated(LENS, np.repeat(poses, COUNT, axis=0), np.tile(ids, 6), noisy, COUNT)
    off = np.abs(found.where[:, 2] / points()[:, 2] - 1)
    said = np.median(found.depth_error(LENS))
    assert 1 < said / (1.48 * np.median(off)) < 2.5
    assert said == pytest.approx(0.0103 / way, rel=0.3)


@pytest.mark.parametrize("factor", [1.0, 1.15])
def test_poses_points_and_a_focal_length_settle_on_exact_places_up_to_scale(factor):
    rng, truth = np.random.default_rng(1), path(8)
    off = [truth[0], *(moved(pose, 0.01 * rng.standard_normal(6)) for pose in truth[1:])]
    bundle = Bundle(
        lens=zoomed(LENS, np.log(factor)),
        poses=np.stack(off),
        points=points() + 0.01 * rng.standard_normal((COUNT, 3)),
        views=np.repeat(np.arange(8), COUNT),
        seen_points=np.tile(np.arange(COUNT), 8),
        seen=seen_at(np.concatenate([places_of(pose, points()) for pose in truth]), 0.5),
        focal=None if factor == 1 else FocalGuess(factor * LENS.fx, 1e4),
    )
    found = adjusted(adjusted(bundle))
    assert np.abs(misfit(found)).max() < 1e-6
    assert found.lens.fx == pytest.approx(LENS.fx, rel=1e-6)
    np.testing.assert_allclose(shape_of(found.poses), shape_of(truth), atol=1e-6)
    np.testing.assert_array_equal(found.poses[0], truth[0])


@pytest.mark.parametrize("blind", [3, 7])
def test_a_view_that_sees_no_point_stays_where_it_is(blind):
    """Also the farthest one, by which the scale would be held."""
    rng, truth = np.random.default_rng(1), path(8)
    off = np.stack([truth[0], *(moved(pose, 0.01 * rng.standard_normal(6)) for pose in truth[1:])])
    views = np.repeat(np.delete(np.arange(8), blind), COUNT)
    places = np.concatenate([places_of(truth[view], points()) for view in np.unique(views)])
    bundle = Bundle(
        lens=LENS,
        poses=off,
        points=points() + 0.01 * rng.standard_normal((COUNT, 3)),
        views=views,
        seen_points=np.tile(np.arange(COUNT), 7),
        seen=seen_at(places, 0.5),
    )
    found = adjusted(adjusted(bundle))
    assert np.abs(misfit(found)).max() < 1e-6
    np.testing.assert_array_equal(found.poses[blind], off[blind])


def test_a_path_is_found_from_tracks_and_its_points_are_a_hundred_units_away():
    truth = path(15)
    found = solved(LENS, [followed(truth)], None)
    done, where = found.done, found.points
    assert not found.lost
    assert found.depth_error < 1e-6
    np.testing.assert_allclose(shape_of([view.pose for view in done.views]), shape_of(truth), atol=1e-6)
    depths = np.concatenate([local(view.pose, done.points)[:, 2] for view in done.views])
    assert np.median(depths) == pytest.approx(MEDIAN_DEPTH, rel=0.05)
    assert len(where) == COUNT


@pytest.mark.parametrize("degrees", [35, 90, 100])
def test_a_field_of_view_far_from_its_guess_is_found(degrees):
    """Growing once from 60 degrees leaves the focal length off by a sixth, a quarter and four fifths."""
    lens, guess, told = Camera.from_fov(degrees, 320, 256), FocalGuess(LENS.fx, FOCAL_SPREAD), []
    truth = path(24)
    done = focused(LENS, [followed(truth, lens=lens)], guess, lambda *each: told.append(each)).done
    assert done.lens.fx == pytest.approx(lens.fx, rel=1e-3)
    np.testing.assert_allclose(shape_of([view.pose for view in done.views]), shape_of(truth), atol=1e-3)
    shares = [count / total for count, total in told]
    assert shares == sorted(shares)
    assert shares[-1] < 1


def slowly(true_fx, noise=lambda fx: 0.02):
    """As `solved`: of what is wrong with the focal length it began with, a twentieth is given up at most."""

    def solved(lens, parts, focal, tell, grey=None):
        left = np.log(true_fx / lens.fx)
        there = zoomed(lens, np.clip(left, -0.045, 0.045))
        done = Settled(there, (), np.zeros((0, 3)), Noise(noise(there.fx), 1.0))
        return Solved(done, np.zeros((0, 3)), 0.0, [])

    return solved


@pytest.mark.parametrize("degrees", [40, 58, 75, 90])
def test_a_field_of_view_that_is_approached_slowly_is_reached(monkeypatch, degrees):
    lens, tell = Camera.from_fov(degrees, 320, 256), lambda *each: None
    monkeypatch.setattr(from_motion, "solved", slowly(lens.fx))
    found = focused(LENS, [], FocalGuess(LENS.fx, FOCAL_SPREAD), tell)
    assert found.done.lens.fx == pytest.approx(lens.fx, rel=0.01)
    assert found.focal_left == 0


def test_one_that_is_too_far_away_to_be_reached_is_said(monkeypatch):
    wide, tell = Camera.from_fov(140, 320, 256), lambda *each: None
    monkeypatch.setattr(from_motion, "solved", slowly(wide.fx))
    assert focused(LENS, [], FocalGuess(LENS.fx, FOCAL_SPREAD), tell).focal_left == pytest.approx(0.045)


def test_where_what_lies_beyond_agrees_less_the_search_goes_on_in_small_steps(monkeypatch):
    lens, tell = Camera.from_fov(75, 320, 256), lambda *each: None
    monkeypatch.setattr(from_motion, "solved", slowly(lens.fx, lambda fx: 0.02 if fx > 230 else 0.03))
    found = focused(LENS, [], FocalGuess(LENS.fx, FOCAL_SPREAD), tell)
    assert 230 < found.done.lens.fx < 245
    assert found.focal_left == pytest.approx(0.045)


def test_a_search_that_ends_early_says_how_much_the_focal_length_still_changed(monkeypatch):
    monkeypatch.setattr(from_motion, "_MOST_TRIES", 1)
    wide = Camera.from_fov(95, 320, 256)
    found = focused(
        LENS, [followed(path(24), lens=wide)], FocalGuess(LENS.fx, FOCAL_SPREAD), lambda *each: None
    )
    assert found.focal_left == pytest.approx(abs(np.log(found.done.lens.fx / LENS.fx)))
    assert found.focal_left > 0.05


@pytest.mark.parametrize("degrees", [105, 115])
def test_a_turn_through_a_lens_that_is_wider_than_its_guess_is_no_path(degrees):
    turns = [moved(np.eye(4), share * STEP * [5, 5, 5, 0, 0, 0]) for share in np.linspace(0, 1, 15)]
    seen = followed(turns, lens=Camera.from_fov(degrees, 320, 256))
    with pytest.raises(Lost, match="the camera only turns"):
        focused(LENS, [seen], FocalGuess(LENS.fx, FOCAL_SPREAD), lambda *each: None)


def bent(places, k1):
    """Places (N, 2) in px as a lens shows them that bends straight lines, by OpenCV's model."""
    slants = (places - (LENS.cx, LENS.cy)) / LENS.fx
    return places + k1 * (slants**2).sum(axis=1, keepdims=True) * slants * LENS.fx


@pytest.mark.parametrize(("k1", "off"), [(-0.1, 0.03), (-0.3, 0.1)])
def test_a_lens_that_bends_straight_lines_leaves_most_of_the_path(k1, off):
    """Although nothing is known of it."""
    truth = path(24)
    seen = followed(truth)
    sights = tuple(replace(each, places=bent(each.places, k1)) for each in seen.sights)
    guess, tell = FocalGuess(LENS.fx, FOCAL_SPREAD), lambda *each: None
    done = focused(LENS, [replace(seen, sights=sights)], guess, tell).done
    assert len(done.views) == 24
    np.testing.assert_allclose(shape_of([view.pose for view in done.views]), shape_of(truth), atol=off)


def test_a_field_of_view_that_is_known_is_not_sought():
    wide = Camera.from_fov(70, 320, 256)
    done = focused(LENS, [followed(path(24), lens=wide)], None, lambda *each: None).done
    assert done.lens == LENS


def test_a_third_that_moves_by_itself_does_not_pull_the_path():
    alone = points()[:, 0] > np.quantile(points()[:, 0], 0.67)

    def pulled(frame):
        return points() + alone[:, None] * np.sin(frame / 5) * (0.03, 0.06, -0.05)

    truth = path(15)
    done = solved(LENS, [followed(truth, pulled)], None).done
    np.testing.assert_allclose(shape_of([view.pose for view in done.views]), shape_of(truth), atol=1e-3)


def test_where_a_clip_breaks_the_frame_is_named_and_the_longer_part_is_kept():
    def shown(frame):
        return slice(0, 65) if frame < 9 else slice(60, COUNT)

    broken = solved(LENS, [followed(path(24), shown=shown)], None)
    lost = broken.lost
    assert [view.frame for view in broken.done.views] == list(range(9, 24))
    assert lost[0].why == "5 points whose place is known"
    assert lost[0].frame in (6, 9)


def test_a_path_that_is_closed_in_a_part_that_is_not_kept_is_not_said_to_be(monkeypatch):
    pairs = ((0, 27), (24, 39), (27, 39))
    monkeypatch.setattr(from_motion, "closed", lambda growing, part, grey: Closed(growing, part, pairs))
    tracked = followed(path(40))
    sights = [replace(each, ids=each.ids[:4], places=each.places[:4]) if 9 < each.frame < 18 else each
              for each in tracked.sights]  # fmt: skip
    found = solved(
        LENS, [replace(tracked, sights=tuple(sights))], None, grey=lambda frame: np.zeros((1, 1), np.uint8)
    )
    assert [view.frame for view in found.done.views] == list(range(18, 40))
    assert found.closed == ((24, 39), (27, 39))


def test_what_is_seen_again_behind_many_frames_that_show_nothing_is_one_part():
    tracked = followed(path(24))
    sights = [replace(each, frame=each.frame + 40 * (each.frame >= 12)) for each in tracked.sights]
    done = solved(LENS, [replace(tracked, sights=tuple(sights))], None).done
    assert [view.frame for view in done.views] == [*range(12), *range(52, 64)]
    np.testing.assert_allclose(shape_of([view.pose for view in done.views]), shape_of(path(24)), atol=1e-6)


@pytest.mark.parametrize(
    ("step", "why"),
    [(STEP * [1, 1, 1, 0, 0, 0], "the camera only turns"), (0 * STEP, "the camera does not move")],
)
def test_a_camera_that_keeps_its_place_tells_no_distances(step, why):
    poses = [moved(np.eye(4), share * step) for share in np.linspace(0, 1, 15)]
    for focal in (None, FocalGuess(LENS.fx, 0.25)):
        with pytest.raises(Lost, match=why):
            solved(LENS, [followed(poses)], focal)


@pytest.mark.parametrize("turning", [0, 1], ids=["still", "turning"])
def test_a_lens_that_zooms_is_no_path(turning):
    def sight(frame):
        pose = moved(np.eye(4), frame / 15 * STEP * [1, 1, 1, 0, 0, 0] * turning)
        return Sight(frame, np.arange(COUNT), places_of(pose, points(), zoomed(LENS, 0.4 * frame / 15)))

    seen = Tracked(tuple(sight(frame) for frame in range(15)), tuple(range(0, 15, 3)), COUNT)
    for focal in (None, FocalGuess(LENS.fx, FOCAL_SPREAD)):
        with pytest.raises(Lost, match="only turns or zooms"):
            solved(LENS, [seen], focal)


def test_a_camera_that_moves_straight_ahead_is_told_from_a_zoom_by_the_relief():
    ahead = [moved(np.eye(4), share * np.r_[0, 0, 0, 0, 0, -0.25]) for share in np.linspace(0, 1, 15)]
    done = solved(LENS, [followed(ahead)], None).done
    np.testing.assert_allclose(shape_of([view.pose for view in done.views]), shape_of(ahead), atol=1e-6)


def test_too_few_frames_are_said():
    with pytest.raises(Lost, match="fewer than 8 frames"):
        solved(LENS, [followed(path(7))], None)


def test_tracks_between_keyframes_keep_their_numbers():
    tracked = followed(path(10))
    part = tracked.between(1, 2)
    assert ([sight.frame for sight in part.sights], part.keys) == ([3, 4, 5, 6, 7, 8], (0, 3))
    assert replace(tracked, keys=(0, 3)).between(1, 1).sights[-1].frame == 9
