"""The camera of rectified pictures follows from the calibration of both eyes."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from renderer.clip import ClipError
from renderer.readers.lenses.rectification import read_rectified

MATRIX = np.array([[1035.0, 0, 596.9], [0, 1036.0, 520.4], [0, 0, 1]])
SHIFT = np.array([-4.1, 0.02, -0.03])
SIZE = 1280, 1024


def turn(angle: float = 0.01) -> np.ndarray:
    return np.asarray(cv2.Rodrigues(np.array([0.2, 1.0, 0.1]) * angle)[0])


def calibration(*, rotation: np.ndarray | None = None, bend: float = 0.0, shift: np.ndarray = SHIFT) -> str:
    """The text of a StereoCalibration.ini."""
    rotation = np.eye(3) if rotation is None else rotation
    poses = {"StereoLeft": (np.eye(3), np.zeros(3)), "StereoRight": (rotation, shift)}
    lines = []
    for section, (spin, place) in poses.items():
        lines += [f"[{section}]", "res_x=1280", "res_y=1024"]
        lines += [
            f"fc_x={MATRIX[0, 0]}",
            f"fc_y={MATRIX[1, 1]}",
            f"cc_x={MATRIX[0, 2]}",
            f"cc_y={MATRIX[1, 2]}",
        ]
        lines += [f"kc_{place}={value}" for place, value in enumerate([bend, 0, 0, 0, 0, 0, 0, 0])]
        lines += [f"R_{place}={value!r}" for place, value in enumerate(map(float, spin.ravel()))]
        lines += [f"T_{place}={value!r}" for place, value in enumerate(map(float, place))]
    return "\n".join(lines)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "StereoCalibration.ini"


def test_eyes_side_by_side_keep_their_camera(path):
    path.write_text(calibration(shift=np.array([-4.0, 0, 0])))
    read = read_rectified(path, SIZE)
    assert read.baseline == pytest.approx(4.0)
    # alpha = 0 fills the picture, and rows take one focal length with columns.
    assert read.camera.fx == read.camera.fy == pytest.approx(1035.5, rel=5e-3)
    assert (read.camera.cx, read.camera.cy) == pytest.approx((597.4, 520.9), abs=3)


@pytest.mark.parametrize("bend", [0.0, -0.05])
def test_points_fall_on_one_row_and_their_disparity_is_depth(path, bend):
    """The letter of rectification, with OpenCV's own rotations: x1 - x2 = f B / z, y1 = y2."""
    path.write_text(calibration(rotation=turn(), bend=bend))
    read = read_rectified(path, SIZE)
    lens, bends = (MATRIX, np.array([bend, 0, 0, 0, 0]))
    first, second, *_ = cv2.stereoRectify(lens, bends, lens, bends, SIZE, turn(), SHIFT[:, None], alpha=0)
    points = np.random.default_rng(0).uniform([-20, -20, 50], [20, 20, 120], (50, 3))
    left = points @ first.T
    right = (points @ turn().T + SHIFT) @ second.T
    one, depth = read.camera.project(left)
    other, _ = read.camera.project(right)
    np.testing.assert_allclose(one[:, 1], other[:, 1], atol=1e-6)
    np.testing.assert_allclose(read.camera.fx * read.baseline / (one[:, 0] - other[:, 0]), depth, rtol=1e-9)
    assert read.baseline == pytest.approx(np.linalg.norm(SHIFT))


def test_smaller_pictures_show_the_same_view(path):
    path.write_text(calibration(rotation=turn()))
    whole, half = read_rectified(path, SIZE), read_rectified(path, (640, 512))
    assert half.camera == whole.camera.resized(640, 512)
    assert half.baseline == whole.baseline


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda text: text.replace("fc_x", "f"), "fc_x"),
        (lambda text: text.replace("[StereoRight]", "[Right]"), "StereoRight"),
        (lambda text: text.replace("R_8=", "R_9="), "R_8"),
        (lambda text: text.replace("cc_y=520.4", "cc_y=middle"), "of numbers .*middle"),
        (lambda text: text.replace("res_x=1280", "res_x=inf"), "of numbers .*infinity"),
        (lambda text: text.replace("T_0=-4.1", "T_0=nan"), "finite number"),
        (lambda text: text.replace("res_x=1280", "res_x=1920"), "1920x1024"),
        (lambda text: text.replace("fc_x=1035.0", "fc_x=0"), "greater than 0"),
        (lambda text: "1280 1024", "NAME = VALUE"),
    ],
)
def test_what_is_no_calibration_is_refused(path, change, said):
    path.write_text(change(calibration()))
    with pytest.raises(ClipError, match=said) as caught:
        read_rectified(path, SIZE)
    assert str(caught.value).endswith(str(path))
    assert "\n" not in str(caught.value)


def test_eyes_in_one_place_are_refused(path):
    path.write_text(calibration(shift=np.zeros(3)))
    with pytest.raises(ClipError, match="more than 0"):
        read_rectified(path, SIZE)
