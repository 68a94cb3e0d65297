from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from renderer.camera import Camera
from renderer.camera_path import TRACK, CameraPath, Keyframe, monotone, velocities
from renderer.rotations import conjugate, exponential, logarithm, matrix, product, quaternion

LENS = Camera(500.0, 480.0, 310.0, 250.0, 640, 512)


def posed(
    rotation: tuple[float, float, float], position: tuple[float, float, float], zoom: float = 1
) -> Camera:
    """A camera turned by a rotation vector in radians, at a position in the world."""
    pose = np.eye(4)
    pose[:3, :3] = matrix(exponential(np.array(rotation)))
    pose[:3, 3] = position
    return replace(LENS, fx=LENS.fx * zoom, fy=LENS.fy * zoom, camera_from_world=np.linalg.inv(pose))


PATH = CameraPath(
    (
        Keyframe(0.0, 0.0, posed((0.0, 0.1, 0.0), (0, 0, -50))),
        Keyframe(1.0, 0.3, posed((0.2, 0.9, -0.3), (20, 5, -40), 1.5)),
        Keyframe(1.5, 0.8, posed((-0.4, 1.9, 0.1), (30, 5, -10), 1.2)),
        Keyframe(4.0, 0.9, posed((0.0, 3.0, 0.2), (10, -5, 30), 0.8)),
    )
)


def motion(path: CameraPath, seconds: float) -> np.ndarray:
    """Everything that moves, as numbers: matrix entries, lens, time."""
    key = path.at(seconds)
    lens = [math.log(key.camera.fx), math.log(key.camera.fy), key.camera.cx, key.camera.cy]
    return np.r_[key.camera.camera_from_world[:3].ravel(), lens, key.time]


def test_it_passes_through_its_keyframes_to_the_bit() -> None:
    for key in PATH.keyframes:
        assert PATH.at(key.seconds) == key
    near = [motion(PATH, key.seconds + 1e-9) for key in PATH.keyframes[:-1]]
    for numbers, key in zip(near, PATH.keyframes, strict=False):
        assert numbers == pytest.approx(motion(PATH, key.seconds), abs=1e-5)


def test_its_track_is_where_the_camera_goes() -> None:
    steps = [np.linspace(a.seconds, b.seconds, TRACK, endpoint=False) for a, b in pairwise(PATH.keyframes)]
    wanted = [PATH.at(second).camera.position for second in (*np.concatenate(steps), PATH.end)]
    np.testing.assert_allclose(PATH.track, wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())
    assert CameraPath(PATH.keyframes[:1]).track.shape == (1, 3)
    assert CameraPath(()).track.shape == (0, 3)


def test_it_has_no_corners() -> None:
    """Velocity just before a keyframe is that just after it, in every number; C1."""
    h = 1e-5
    for key in PATH.keyframes[1:-1]:
        t = key.seconds
        before = (motion(PATH, t) - motion(PATH, t - h)) / h
        after = (motion(PATH, t + h) - motion(PATH, t)) / h
        assert before == pytest.approx(after, abs=2e-3 * np.abs(before).max())
        assert np.abs(before).max() > 0.1


@given(st.floats(0, 4))
def test_it_stays_rigid_and_within_the_clip(seconds: float) -> None:
    key = PATH.at(seconds)
    rotation = key.camera.camera_from_world[:3, :3]
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    assert 0 <= key.time <= 1


def test_time_never_runs_back_between_rising_keyframes() -> None:
    times = [PATH.at(seconds).time for seconds in np.linspace(0, 4, 401)]
    assert (np.diff(times) >= 0).all()


def test_equal_keyframes_are_one_view_that_rests() -> None:
    camera = PATH.keyframes[1].camera
    path = CameraPath(tuple(Keyframe(float(s), 0.4, camera) for s in (0, 1, 5)))
    for seconds in np.linspace(0, 5, 23):
        assert motion(path, seconds) == pytest.approx(motion(path, 0.0), abs=1e-12)


def test_between_two_equal_keyframes_the_camera_rests_though_it_moves_before_and_after() -> None:
    first, held, last = (PATH.keyframes[place].camera for place in (0, 1, 2))
    path = CameraPath(
        (Keyframe(0, 0.1, first), Keyframe(1, 0.5, held), Keyframe(2, 0.5, held), Keyframe(3, 0.2, last))
    )
    for seconds in (1.2, 1.5, 1.9):
        assert motion(path, seconds) == pytest.approx(motion(path, 1.0), abs=1e-12)
    assert not np.allclose(motion(path, 0.5), motion(path, 1.0))


def test_two_keyframes_of_one_turn_are_a_steady_turn() -> None:
    """With nothing else to go by, the middle of the way is half the angle: the shorter way round."""
    path = CameraPath(
        (Keyframe(0, 0, posed((0, 0, 0), (0, 0, 0))), Keyframe(2, 1, posed((0, 2.6, 0), (4, 0, 0))))
    )
    for share in (0.25, 0.5, 0.75):
        middle = path.at(2 * share)
        expected = posed((0, 2.6 * share, 0), (4 * share, 0, 0)).camera_from_world
        assert middle.camera.camera_from_world == pytest.approx(expected, abs=1e-9)
        assert middle.time == pytest.approx(share)


def test_a_turn_on_and_on_never_flips() -> None:
    """Past 180 degrees the quaternion of a matrix changes its sign; the way must not."""
    keys = [Keyframe(float(n), 0.0, posed((0, 0.5 * n, 0), (0, 0, 0))) for n in range(14)]
    path = CameraPath(tuple(keys))
    at = [quaternion(path.at(t).camera.world_from_camera[:3, :3]) for t in np.linspace(0, 13, 261)]
    steps = [np.linalg.norm(logarithm(product(conjugate(a), b))) for a, b in pairwise(at)]
    assert max(steps) == pytest.approx(min(steps), rel=0.01)


@pytest.mark.parametrize("second", [0.1, 0.2, 1.0, 9.0])
def test_however_uneven_the_seconds_it_stays_between_its_keyframes_and_turns_the_short_way(
    second: float,
) -> None:
    places, zooms = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0)), (1.0, 4.0, 4.1)
    keys = [
        Keyframe(seconds, 0.0, replace(posed((0, yaw, 0), place, zoom), cx=center))
        for seconds, yaw, place, zoom, center in zip(
            (0.0, second, 10.0), (0.0, 1.5, 3.0), places, zooms, (310.0, 310.0, 400.0), strict=True
        )
    ]
    path = CameraPath(tuple(keys))
    for first, last in pairwise(keys):
        cameras = [path.at(t).camera for t in np.linspace(first.seconds, last.seconds, 101)]
        turns = [quaternion(camera.world_from_camera[:3, :3]) for camera in cameras]
        turned = [np.linalg.norm(logarithm(product(conjugate(a), b))) for a, b in pairwise(turns)]
        assert sum(turned) == pytest.approx(1.5, rel=1e-6)
        for numbers in ([camera.position[0] for camera in cameras], [camera.fx for camera in cameras]):
            assert (np.diff(numbers) >= -1e-9).all()


def test_between_like_segments_the_velocity_is_the_mean_of_both_to_the_bit() -> None:
    differences = np.array([[1.0, 0.1, 0.0], [0.7, 0.9, -0.3], [0.2, 1.1, 0.4]])
    found = velocities(differences, np.full(3, 1.0), 1e-9, closed=False)
    np.testing.assert_array_equal(found[1:-1], (differences[:-1] + differences[1:]) / 2)


def test_a_closed_path_goes_through_its_seam_without_a_corner() -> None:
    keys = (*PATH.keyframes, replace(PATH.keyframes[0], seconds=6.0))
    h = 1e-5
    closed = CameraPath(keys)
    leaving = (motion(closed, h) - motion(closed, 0))[:12]
    arriving = (motion(closed, 6.0) - motion(closed, 6.0 - h))[:12]
    assert arriving / h == pytest.approx(leaving / h, abs=1e-2)
    assert np.abs(leaving / h).max() > 1


def test_the_unit_of_the_scene_does_not_matter() -> None:
    def scaled(camera: Camera) -> Camera:
        pose = camera.camera_from_world.copy()
        pose[:3, 3] *= 1e-6
        return camera.moved(pose)

    tiny = CameraPath(tuple(replace(key, camera=scaled(key.camera)) for key in PATH.keyframes))
    for seconds in (0.3, 1.2, 3.0):
        large = scaled(PATH.at(seconds).camera).camera_from_world
        assert tiny.at(seconds).camera.camera_from_world == pytest.approx(large, rel=1e-9, abs=1e-12)


def test_moments_are_even_and_reach_the_end() -> None:
    moments = PATH.moments(10.0)
    assert [key.seconds for key in moments] == pytest.approx([n / 10 for n in range(41)])
    assert moments[-1] == PATH.keyframes[-1]
    assert len(CameraPath(PATH.keyframes[:1]).moments(15.0)) == 1
    odd = PATH.moments(2.9)
    assert [key.seconds for key in odd[:-1]] == pytest.approx([n / 2.9 for n in range(12)])
    assert odd[-1] == PATH.keyframes[-1]


def test_outside_it_stands_still() -> None:
    assert PATH.at(-3.0) == PATH.keyframes[0]
    assert PATH.at(99.0) == PATH.keyframes[-1]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"seconds": 1.0}, "expected more than"),
        ({"seconds": math.nan}, "finite"),
        ({"time": 1.5}, r"\[0, 1\]"),
    ],
)
def test_what_is_no_path_is_refused(changes: dict[str, float], words: str) -> None:
    broken = replace(PATH.keyframes[2], **changes)
    with pytest.raises(ValueError, match=words):
        CameraPath((*PATH.keyframes[:2], broken))
    with pytest.raises(ValueError, match="at least one"):
        CameraPath(()).at(0.0)


@given(st.tuples(*[st.floats(-3.1, 3.1)] * 3))
def test_logarithm_and_exponential_are_inverse_and_the_sign_does_not_matter(
    vector: tuple[float, ...],
) -> None:
    rotation = np.array(vector)
    turn = exponential(rotation)
    assert np.linalg.norm(turn) == pytest.approx(1.0)
    for sign in (1, -1):
        assert exponential(logarithm(sign * turn)) @ turn == pytest.approx(
            math.copysign(1, turn[0]), abs=1e-9
        )
    assert abs(quaternion(matrix(turn)) @ turn) == pytest.approx(1.0)


def test_speeds_of_uneven_steps_are_the_weighted_harmonic_mean_of_their_slopes() -> None:
    slopes, steps = np.array([2.0, 1.0, -1.0, -4.0]), np.array([1.0, 3.0, 2.0, 2.0])
    middle = (7 + 5) / (7 / 2 + 5 / 1), 0.0, (6 + 6) / (6 / -1 + 6 / -4)
    np.testing.assert_allclose(monotone(slopes * steps, steps)[:, 0], [2, *middle, -4])
