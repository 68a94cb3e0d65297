from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.scenes.free_camera import MAX_DISTANCE, MAX_PITCH, MIN_DISTANCE, FreeView, Vector, vector
from renderer.camera import Camera

POSE = np.array([[0.0, -1, 0, 3], [1, 0, 0, -2], [0, 0, 1, 5], [0, 0, 0, 1]])
CLIP_CAMERA = Camera(500.0, 480.0, 310.0, 250.0, 640, 512, POSE)
DISTANCE = 60.0
START = FreeView.of(CLIP_CAMERA)
angles = st.floats(-3.0, 3.0)
pixels = st.tuples(st.floats(0, 640), st.floats(0, 512))


def behind(pixel: tuple[float, float], depth: float = DISTANCE) -> Vector:
    """The point of the world that a pixel of the frame shows."""
    ray = np.array([(pixel[0] - 310) / 500, (pixel[1] - 250) / 480, 1.0]) * depth
    return vector((CLIP_CAMERA.world_from_camera @ [*ray, 1.0])[:3])


def seen(view: FreeView, point: Vector) -> tuple[np.ndarray, float]:
    at, depth = view.camera.project(np.array([point]))
    return at[0], float(depth[0])


@given(pixels, angles, st.floats(-1.5, 1.5), st.floats(0.3, 4.0))
def test_turning_and_zooming_keep_the_picked_point_where_it_is_on_screen(
    pixel: tuple[float, float], yaw: float, pitch: float, factor: float
) -> None:
    point = behind(pixel)
    view = START.orbited(point, yaw, pitch)
    at, depth = seen(view, point)
    assert at == pytest.approx(pixel, abs=1e-6)
    assert depth == pytest.approx(DISTANCE)
    at, depth = seen(view.zoomed(point, factor, DISTANCE), point)
    assert at == pytest.approx(pixel, abs=1e-6)
    assert depth == pytest.approx(DISTANCE / factor)


@given(st.lists(st.tuples(angles, st.floats(-9, 9)), max_size=5))
def test_the_camera_stays_rigid_and_upright(turns: list[tuple[float, float]]) -> None:
    view = START
    for yaw, pitch in turns:
        view = view.orbited(behind((100, 400)), yaw, pitch)
    rotation = view.camera.camera_from_world[:3, :3]
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-12)
    assert rotation[0] @ view.down == pytest.approx(0, abs=1e-9)  # No roll: right stays level.
    assert abs(rotation[2] @ view.down) <= math.sin(MAX_PITCH) + 1e-9
    assert rotation[1] @ view.down > 0


def test_panning_moves_the_point_by_just_these_pixels() -> None:
    point = behind((200, 300))
    at, depth = seen(START.orbited(point, 0.3, 0.2).panned(point, 12.0, -7.0), point)
    assert at == pytest.approx((212.0, 293.0))
    assert depth == pytest.approx(DISTANCE)


@pytest.mark.parametrize(("factor", "share"), [(1e9, MIN_DISTANCE), (1e-9, MAX_DISTANCE)])
def test_zooming_ends_near_and_far(factor: float, share: float) -> None:
    point = behind((310, 250))
    assert seen(START.zoomed(point, factor, DISTANCE), point)[1] == pytest.approx(share * DISTANCE)


def test_zooming_at_one_s_own_place_does_nothing() -> None:
    assert START.zoomed(vector(CLIP_CAMERA.position), 2.0, DISTANCE) == START


@given(angles, st.floats(-1.4, 1.4))
def test_looking_around_stays_on_the_spot(yaw: float, pitch: float) -> None:
    looked = START.looked(yaw, pitch)
    assert looked.camera.position == pytest.approx(CLIP_CAMERA.position, abs=1e-9)


def test_flight_goes_right_down_and_forward_in_the_camera_s_own_axes() -> None:
    view = START.looked(0.7, 0.3)
    moved = view.flown(1.0, 2.0, 3.0).camera.position - view.camera.position
    assert view.camera.camera_from_world[:3, :3] @ moved == pytest.approx((1.0, 2.0, 3.0))


def test_positive_angles_move_the_near_side_left_and_down() -> None:
    near = behind((310, 250), DISTANCE / 2)
    at, _ = seen(START.orbited(behind((310, 250)), 0.2, 0.2), near)
    assert at[0] < 310
    assert at[1] > 250
