from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.gui.orbit import MAX_PITCH, Orbit
from renderer.camera import Camera

POSE = np.array([[0.0, -1, 0, 3], [1, 0, 0, -2], [0, 0, 1, 5], [0, 0, 0, 1]])
PHOTO = Camera(500.0, 480.0, 310.0, 250.0, 640, 512, POSE)
DISTANCE = 60.0
angles = st.floats(-3.0, 3.0)


def pivot() -> np.ndarray:
    """(1, 3) the orbit's centre in the world."""
    return (PHOTO.world_from_camera @ [0, 0, DISTANCE, 1])[None, :3]


def test_the_start_is_the_photo_itself() -> None:
    assert Orbit().camera(PHOTO, DISTANCE, (640, 512)) == PHOTO


@pytest.mark.parametrize("size", [(900, 220), (300, 900), (64, 64)])
def test_the_whole_photo_is_in_view_and_centred(size: tuple[int, int]) -> None:
    camera = Orbit().camera(PHOTO, DISTANCE, size)
    corners = np.array([[0, 0], [640, 512]], dtype=float)
    rays = np.stack([(corners[:, 0] - 310) / 500, (corners[:, 1] - 250) / 480, np.ones(2)], axis=1)
    world = rays @ PHOTO.world_from_camera[:3, :3].T + PHOTO.position
    (first, last), _ = camera.project(world)
    assert (first >= -1e-9).all()
    assert last[0] <= size[0] + 1e-9
    assert last[1] <= size[1] + 1e-9
    assert first + last == pytest.approx(np.array(size, dtype=float))


@given(angles, st.floats(-1.5, 1.5), st.floats(0.2, 5.0))
def test_turning_and_dollying_keep_the_pivot_in_place(yaw: float, pitch: float, dolly: float) -> None:
    orbit = Orbit().orbited(yaw, pitch).zoomed(dolly)
    at, depth = orbit.camera(PHOTO, DISTANCE, (640, 512)).project(pivot())
    assert at[0] == pytest.approx((310.0, 250.0), abs=1e-6)
    assert depth[0] == pytest.approx(DISTANCE / dolly)


@given(angles, st.floats(-9, 9))
def test_the_camera_stays_rigid_and_upright(yaw: float, pitch: float) -> None:
    orbit = Orbit().orbited(yaw, pitch)
    rotation = orbit.camera(PHOTO, DISTANCE, (64, 64)).camera_from_world[:3, :3]
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-12)
    assert abs(orbit.pitch) <= MAX_PITCH < math.pi / 2
    assert abs(orbit.yaw) <= math.pi + 1e-9


def test_panning_moves_the_pivot_with_the_hand() -> None:
    at, _ = Orbit().zoomed(2.0).panned(0.1, 0.0).camera(PHOTO, DISTANCE, (640, 512)).project(pivot())
    assert at[0] == pytest.approx((310 + 0.1 * 500, 250.0))


def test_positive_angles_move_the_near_side_left_and_down() -> None:
    near = (PHOTO.world_from_camera @ [0, 0, DISTANCE / 2, 1])[None, :3]
    at, _ = Orbit().orbited(0.2, 0.2).camera(PHOTO, DISTANCE, (640, 512)).project(near)
    assert at[0, 0] < 310
    assert at[0, 1] > 250
