"""Camera conventions: where a known point falls, and that projecting and unprojecting are inverse."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from renderer.camera import Camera, CameraError
from tests.renderer.scenes import turned_camera


def test_known_point_falls_on_known_pixel() -> None:
    """OpenCV axes: x right, y down, z forward; (0, 0) is the outer corner of the first pixel."""
    camera = Camera(100, 200, 32, 24, 64, 48)
    pixels, depths = camera.project(np.array([[0.0, 0, 2], [0.1, 0, 2], [0, 0.1, 2]]))
    assert pixels.tolist() == [[32, 24], [37, 24], [32, 34]]
    assert depths.tolist() == [2, 2, 2]


def test_unproject_is_the_inverse_of_project_at_pixel_centres() -> None:
    camera = turned_camera(31, 22)
    depth = np.random.default_rng(0).uniform(5, 90, (22, 31))
    pixels, depths = camera.project(camera.unproject(depth).reshape(-1, 3))
    column, row = np.meshgrid(np.arange(31) + 0.5, np.arange(22) + 0.5)
    assert np.allclose(pixels, np.stack([column.ravel(), row.ravel()], 1), atol=1e-9)
    assert np.allclose(depths, depth.ravel(), atol=1e-9)


def test_position_is_where_depth_is_zero() -> None:
    camera = turned_camera(31, 22)
    local = camera.camera_from_world @ np.array([*camera.position, 1.0])
    assert np.allclose(local[:3], 0, atol=1e-12)


@given(st.integers(1, 400), st.integers(1, 400))
def test_resizing_scales_pixel_positions(width: int, height: int) -> None:
    camera = turned_camera(64, 48)
    points = camera.world_from_camera[:3, 3] + camera.world_from_camera[:3, :3] @ np.array([0.3, -0.2, 4.0])
    before, _ = camera.project(points[None])
    after, _ = camera.resized(width, height).project(points[None])
    assert np.allclose(after[0] / [width, height], before[0] / [64, 48], atol=1e-12)


@given(st.integers(1, 400), st.integers(1, 400))
def test_another_shape_stretches_nothing_and_holds_the_whole_picture(width: int, height: int) -> None:
    camera = turned_camera(64, 48)
    shaped = camera.shaped(width, height)
    assert shaped.fx / camera.fx == pytest.approx(shaped.fy / camera.fy, rel=1e-12)
    assert shaped.fx / camera.fx == pytest.approx(min(width / 64, height / 48), rel=1e-12)
    if camera.has_shape(width, height):
        assert shaped == camera.resized(width, height)


def test_json_round_trip_is_exact() -> None:
    camera = turned_camera(64, 48)
    assert Camera.from_json(camera.to_json()) == camera
    assert hash(Camera.from_json(camera.to_json())) == hash(camera)
    assert camera != camera.resized(32, 24)


def test_field_of_view() -> None:
    camera = Camera.from_fov(90, 64, 48)
    pixels, _ = camera.project(np.array([[-1.0, 0, 1], [1, 0, 1]]))
    assert np.allclose(pixels[:, 0], [0, 64])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"width": 0}, "at least 1x1"),
        ({"fx": 0.0}, "fx, fy > 0"),
        ({"cy": float("nan")}, "finite intrinsics"),
        ({"camera_from_world": np.eye(3)}, r"\(4, 4\)"),
        ({"camera_from_world": np.full((4, 4), np.inf)}, "finite"),
        ({"camera_from_world": np.zeros((4, 4))}, "rotation"),
        ({"camera_from_world": np.diag([1.0, 1, 0, 1])}, "rotation"),
        ({"camera_from_world": np.diag([1e200, 1, 1, 1])}, "rotation"),
        ({"camera_from_world": np.diag([2.0, 2, 2, 1])}, "rotation"),
        ({"camera_from_world": np.diag([1.0, 1, 1, 0])}, "0 0 0 1"),
        ({"camera_from_world": np.eye(4) + np.outer([1e20, 0, 0, 0], [0, 0, 0, 1])}, "a last row 0 0 0 1"),
        ({"cx": 1e20}, "principal point"),
    ],
)
def test_impossible_cameras_are_refused(changes: dict[str, object], words: str) -> None:
    values: dict[str, object] = {"fx": 10.0, "fy": 10.0, "cx": 4.0, "cy": 4.0, "width": 8, "height": 8}
    with pytest.raises(ValueError, match=words):
        Camera(**(values | changes))  # type: ignore[arg-type]


def test_json_without_a_field_says_so() -> None:
    values = turned_camera(8, 8).to_json()
    del values["cx"]
    with pytest.raises(ValueError, match=r"got no cx$"):
        Camera.from_json(values)


@pytest.mark.parametrize("size", [(900, 220), (300, 900), (64, 64), (640, 512)])
def test_a_fitted_camera_holds_the_whole_field_in_the_middle(size: tuple[int, int]) -> None:
    camera = Camera(500.0, 480.0, 310.0, 250.0, 640, 512)
    fitted = camera.fitted(*size)
    corners = np.array([[0, 0], [640, 512]], dtype=float)
    rays = np.stack([(corners[:, 0] - 310) / 500, (corners[:, 1] - 250) / 480, np.ones(2)], axis=1)
    (first, last), _ = fitted.project(rays)
    assert (first >= -1e-9).all()
    assert last[0] <= size[0] + 1e-9
    assert last[1] <= size[1] + 1e-9
    assert first + last == pytest.approx(np.array(size, dtype=float))
    assert fitted.fx / fitted.fy == pytest.approx(500 / 480)
    if size == (640, 512):
        assert fitted == camera


@given(
    st.floats(-6.5, 3.5), st.floats(-6.5, 3.5), st.floats(-1e15, 1e15), st.integers(1, 8000),
    st.integers(1, 8000), st.integers(1, 4000), st.integers(1, 4000), st.floats(-1e15, 1e15),
)  # fmt: skip
def test_what_is_made_of_a_camera_is_one(
    wide: float, high: float, middle: float, width: int, height: int, across: int, down: int, away: float
) -> None:
    pose = np.eye(4)
    pose[2, 3] = away
    camera = Camera(width / 10**wide, width / 10**high, middle, -middle, width, height, pose)
    for made in (camera.fitted(across, down), camera.resized(across, down), camera.shaped(across, down)):
        assert (made.width, made.height) == (across, down)
        assert made.fitted(down, across).fitted(1, 1).resized(3000, 1).width == 3000


def test_numbers_of_numpy_become_those_of_json() -> None:
    size = np.int64(64), np.int16(48)
    camera = Camera(np.float32(80), np.float64(81), 32, np.float16(24), *size)  # type: ignore[arg-type]
    assert json.loads(json.dumps(camera.to_json())) == Camera(80, 81, 32, 24, 64, 48).to_json()
    assert Camera.from_json(camera.to_json()) == camera


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"width": 64.5}, "a whole number of pixels as width, got 64.5"),
        ({"height": None}, "a whole number of pixels as height, got None"),
        ({"fx": "80"}, "a number as fx, got '80'"),
        ({"cy": None}, "a number as cy, got None"),
        ({"camera_from_world": "x"}, r"camera_from_world to be a \(4, 4\) matrix, got 'x'"),
        ({"camera_from_world": [[1, 2], [3]]}, r"camera_from_world to be a \(4, 4\) matrix, got \[\["),
    ],
)
def test_what_is_no_number_is_refused(change: dict[str, Any], said: str) -> None:
    with pytest.raises(CameraError, match=f"expected {said}"):
        Camera(**{**Camera(80, 80, 32, 24, 64, 48).to_json(), **change})


@pytest.mark.parametrize("angle", [0, 180, -10, 200, np.nan])
def test_a_field_of_view_is_between_0_and_180_degrees(angle: float) -> None:
    with pytest.raises(CameraError, match=r"expected a field of view in \(0, 180\) degrees, got"):
        Camera.from_fov(angle, 64, 48)


def test_minus_zero_is_the_same_pose() -> None:
    pose = np.eye(4)
    pose[:3, 3] = -0.0
    one, other = (Camera(80, 80, 32, 24, 64, 48, matrix) for matrix in (np.eye(4), pose))
    assert one == other
    assert hash(one) == hash(other)
    assert np.signbit(other.to_json()["camera_from_world"][0][3])
