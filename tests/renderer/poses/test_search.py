"""The path of a camera is found from a phantom whose poses were erased; else the reason is named."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from renderer.clip import Clip, Frame
from renderer.phantom import Phantom, PhantomParams
from renderer.poses import settling
from renderer.poses.parts import MOST_BRIDGED
from renderer.poses.search import PosesError, find_poses
from renderer.poses.views import View
from tests.benchmarks import camera_poses

COUNT = 24


@cache
def phantom():
    params = PhantomParams(
        n_frames=COUNT, width=160, height=128, seed=5, camera="moving", tissue="static", tools=1
    )
    return Phantom(params)


@cache
def pulled():
    """Tissue that is pulled in one place, and rests nowhere quite."""
    return camera_poses.phantom("pull", COUNT, 0, (160, 128))


@cache
def drawn(index, scene=phantom):
    return scene().view(index).frame


def clip_of(change=lambda frame: frame, scene=phantom):
    """The phantom with its poses erased, every frame passed through `change`."""
    camera = scene().camera(0)

    def read_frame(index):
        return change(replace(drawn(index, scene), camera=camera))

    return Clip(
        name="phantom",
        path=Path("phantom"),
        format="endonerf",
        cameras=(camera,) * COUNT,
        read_frame=read_frame,
        read_image=lambda index: read_frame(index).image,
        labels=tuple(map(str, range(COUNT))),
        has_depth=True,
        unit="mm",
    )


def blackened(*frames):
    def change(frame: Frame) -> Frame:
        return replace(frame, image=np.zeros_like(frame.image)) if frame.index in frames else frame

    return clip_of(change)


def errors(found, scene=phantom):
    """Per frame: distance from the truth over the path's length, and degrees; in the first camera's axes."""
    cameras = [scene().camera(found.first + at) for at in range(len(found.cameras))]
    back = np.linalg.inv(cameras[0].camera_from_world)
    true = [camera.moved(camera.camera_from_world @ back) for camera in cameras]
    places = np.array([camera.position for camera in true])
    way = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
    off = np.linalg.norm(np.array([camera.position for camera in found.cameras]) - places, axis=1)
    pairs = zip(found.cameras, true, strict=True)
    turns = [a.camera_from_world[:3, :3] @ b.camera_from_world[:3, :3].T for a, b in pairs]
    angles = [np.degrees(np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1))) for turn in turns]
    return off / way, np.array(angles)


@cache
def of_all():
    return find_poses(clip_of())


def test_the_path_is_within_half_a_percent_and_half_a_degree():
    found = of_all()
    assert (found.first, found.last, found.lost) == (0, COUNT - 1, ())
    off, angles = errors(found)
    assert np.sqrt(np.mean(off**2)) < 0.005
    assert angles.max() < 0.5
    assert max(found.residuals) < 1
    assert min(found.points) > 100
    np.testing.assert_allclose(found.cameras[0].camera_from_world, np.eye(4), atol=1e-9)


def test_where_tissue_is_pulled_what_moves_least_is_the_world():
    """The steadier half of the points leaves 3.8 % and 1.4 degrees, a seventh 2.1 % and 0.7."""
    off, angles = errors(find_poses(clip_of(scene=pulled)), pulled)
    assert np.sqrt(np.mean(off**2)) < 0.018
    assert np.sqrt(np.mean(angles**2)) < 0.6


def test_turns_stay_turns_however_often_views_are_carried():
    scene = pulled()
    poses = [scene.camera(at).camera_from_world for at in range(COUNT)]
    views = tuple(View(at, pose, *[np.zeros(0)] * 3) for at, pose in enumerate(poses))
    for _ in range(40):
        carried = settling._carried((0, 7), views, np.stack([views[0].pose, views[7].pose]))
        views = tuple(replace(view, pose=pose) for view, pose in zip(views, carried, strict=True))
    np.testing.assert_allclose([view.pose for view in views], poses, atol=1e-12)


def test_where_the_steadiest_come_to_agree_less_all_stays_as_it_was(monkeypatch):
    asked = []

    def noted(rough, soft):
        done = narrowed(rough, soft)
        asked.append(done is soft)
        return done

    narrowed = settling._by_the_steadiest
    monkeypatch.setattr(settling, "_AGREEING", 0.0)
    monkeypatch.setattr(settling, "_by_the_steadiest", noted)
    find_poses(clip_of(scene=pulled).between(0, 11))
    assert asked == [True]


def test_depth_in_other_units_gives_the_same_path_in_these():
    def in_metres(frame):
        return replace(frame, depth=frame.depth / np.float32(1000))

    here, there = of_all(), find_poses(clip_of(in_metres))
    for one, other in zip(here.cameras, there.cameras, strict=True):
        np.testing.assert_allclose(1000 * other.position, one.position, atol=0.01)


def test_a_black_frame_is_named_and_bridged():
    found = find_poses(blackened(10))
    assert [(each.frame, each.why) for each in found.lost] == [(10, "0 points followed")]
    assert found.residuals[10] is None
    off, angles = errors(found)
    assert off.max() < 0.01
    assert angles.max() < 0.5


def test_the_longest_part_is_kept_where_many_frames_are_black():
    black = range(4, 4 + MOST_BRIDGED + 2)
    found = find_poses(blackened(*black))
    assert (found.first, found.last) == (black.stop, COUNT - 1)
    assert {each.frame for each in found.lost} == set(black)
    assert errors(found)[0].max() < 0.01


def test_behind_what_covers_the_view_for_long_the_camera_is_found_again():
    """Another tissue, with depth of its own."""
    cover = drawn(0, scene=pulled)
    hidden = range(9, 9 + MOST_BRIDGED + 3)

    def covered(frame):
        return replace(cover, index=frame.index, time=frame.time) if frame.index in hidden else frame

    found = find_poses(clip_of(covered))
    assert (found.first, found.last) == (0, COUNT - 1)
    assert [each.frame for each in found.lost] == list(hidden)
    assert found.lost[-1].why == "shows nothing that the others do"
    seen = [at for at in range(COUNT) if at not in hidden]
    assert all((found.residuals[at] is None) == (at in hidden) for at in range(COUNT))
    off, angles = errors(found)
    assert off[seen].max() < 0.01
    assert angles[seen].max() < 0.5


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda frame: replace(frame, depth=np.zeros_like(frame.depth)), "0 points with depth"),
        (lambda frame: replace(frame, depth=None), "0 points with depth"),
        (lambda frame: replace(frame, image=np.full_like(frame.image, 120)), "0 points with depth"),
        (lambda frame: replace(frame, tissue_mask=np.zeros_like(frame.tissue_mask)), "0 points with depth"),
    ],
    ids=["depth 0", "no depth", "one grey", "no tissue"],
)
def test_what_shows_nothing_has_no_poses_and_says_why(change, why):
    with pytest.raises(PosesError, match=why):
        find_poses(clip_of(change).between(0, 9))


def test_a_clip_of_too_few_frames_is_told_how_many_are_needed():
    with pytest.raises(PosesError, match="expected at least 8 frames to follow the camera through, got 2"):
        find_poses(clip_of().between(0, 1))


def test_frames_that_have_nothing_in_common_are_named():
    def noise(frame):
        rng = np.random.default_rng(frame.index)
        return replace(frame, image=rng.integers(30, 240, frame.image.shape).astype(np.uint8))

    with pytest.raises(PosesError, match="points"):
        find_poses(clip_of(noise).between(0, 9))


def test_a_camera_that_does_not_move_keeps_its_place():
    still = clip_of()
    first = still.read_frame(0)
    found = find_poses(replace(still, read_frame=lambda index: replace(first, index=index)))
    distance = float(np.median(first.depth[first.depth > 0]))
    assert max(np.linalg.norm(camera.position) for camera in found.cameras) < 1e-4 * distance


def test_following_is_told_as_half_of_the_work():
    told = []
    with pytest.raises(PosesError):
        find_poses(blackened(*range(COUNT)), lambda *now: told.append(now))
    assert told == [(index // 2, COUNT) for index in range(COUNT)]
