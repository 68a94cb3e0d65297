"""Calibrations in the forms that programs write: the same lens from each, and one line for what is none."""

from __future__ import annotations

import json
import re

import cv2
import numpy as np
import pytest

from renderer.clip import ClipError
from renderer.readers.lenses.calibration import Calibration, LensCalibration
from renderer.readers.lenses.calibration_files import read_calibration

MATRIX = [[438.5, 0.0, 305.25], [0.0, 437.0, 243.75], [0.0, 0.0, 1.0]]
BENT = [-0.36, 0.11, 0.001, 1e-5, -0.02]
SIZE = (640, 480)
LENS = LensCalibration(fx=438.5, fy=437.0, cx=305.25, cy=243.75, distortion=tuple(BENT), size=SIZE)
TURN = cv2.Rodrigues(np.array([0.01, -0.03, 0.02]))[0].tolist()
SHIFT = [-4.25, 0.125, -0.0625]

ROS = f"""
image_width: 640
image_height: 480
camera_name: narrow
camera_matrix:
  rows: 3
  cols: 3
  data: [438.5, 0, 305.25, 0, 437, 243.75, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients: {{rows: 1, cols: 5, data: {BENT}}}
"""
KALIBR_EYE = """
  camera_model: pinhole
  distortion_coeffs: [-0.36, 0.11, 0.001, 1.0e-05]
  distortion_model: MODEL
  intrinsics: [438.5, 437.0, 305.25, 243.75]
  resolution: [640, 480]
"""


def written(tmp_path, name, content):
    path = tmp_path / name
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


def by_opencv(path, values):
    store = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, value in values.items():
        store.write(name, np.array(value) if isinstance(value, list) else value)
    store.release()
    return path


def one_eye():
    return {
        "image_width": 640, "image_height": 480, "camera_matrix": MATRIX, "distortion_coefficients": [BENT]
    }  # fmt: skip


def two_eyes(names):
    left, bent, right, other = names
    return {
        left: MATRIX,
        bent: [BENT],
        right: MATRIX,
        other: [BENT],
        "R": TURN,
        "T": [[each] for each in SHIFT],
    }


@pytest.mark.parametrize("suffix", ["yml", "yaml", "json", "xml"])
def test_what_opencv_writes(tmp_path, suffix):
    assert read_calibration(by_opencv(tmp_path / f"lens.{suffix}", one_eye())) == Calibration(lens=LENS)


def test_what_ros_writes(tmp_path):
    assert read_calibration(written(tmp_path, "ost.yaml", ROS)) == Calibration(lens=LENS)
    fish = ROS.replace("plumb_bob", "equidistant").replace(", -0.02]", "]")
    assert read_calibration(written(tmp_path, "ost.yaml", fish)).lens.model == "fisheye"


@pytest.mark.parametrize("names", ["DK", "dk"])
def test_what_ros_prints_of_a_message(tmp_path, names):
    bent, matrix = names
    text = f"""header:
  frame_id: left
height: 480
width: 640
distortion_model: plumb_bob
{bent}: {BENT}
{matrix}: {[each for row in MATRIX for each in row]}
binning_x: 0
---
"""
    assert read_calibration(written(tmp_path, "info.yaml", text)) == Calibration(lens=LENS)


def test_the_size_as_a_pair(tmp_path):
    values = {"camera_matrix": MATRIX, "dist_coeffs": BENT, "image_size": SIZE}
    assert read_calibration(written(tmp_path, "a.json", values)).lens == LENS


@pytest.mark.parametrize("names", [("mtx", "dist"), ("K", "D"), ("cameraMatrix", "distCoeffs")])
def test_json_of_a_script(tmp_path, names):
    found = read_calibration(written(tmp_path, "a.json", dict(zip(names, (MATRIX, [BENT]), strict=True))))
    assert found.lens.matrix.tolist() == MATRIX
    assert found.lens.distortion == tuple(BENT)
    assert found.lens.size is None


@pytest.mark.parametrize(
    "names", [("M1", "D1", "M2", "D2"), ("cameraMatrix1", "distCoeffs1", "cameraMatrix2", "distCoeffs2")]
)
@pytest.mark.parametrize("suffix", ["yml", "json", "xml"])
def test_both_eyes(tmp_path, names, suffix):
    found = read_calibration(by_opencv(tmp_path / f"eyes.{suffix}", two_eyes(names)))
    assert found.right is not None
    np.testing.assert_allclose(found.right.rotation, TURN, atol=1e-12)
    assert found.right.shift == tuple(SHIFT)
    assert found.right.lens == found.lens


def test_both_files_of_the_stereo_example(tmp_path):
    values = two_eyes(("M1", "D1", "M2", "D2"))
    path = by_opencv(
        tmp_path / "intrinsics.yml", {name: values.pop(name) for name in ("M1", "D1", "M2", "D2")}
    )
    with pytest.raises(ClipError, match="expected R and T"):
        read_calibration(path)
    beside = by_opencv(tmp_path / "extrinsics.yml", values | {"Q": np.eye(4).tolist()})
    found = read_calibration(path)
    assert found.right is not None
    assert found.right.shift == tuple(SHIFT)
    beside.write_text("nothing")
    with pytest.raises(ClipError, match=r"in extrinsics\.yml beside it: "):
        read_calibration(path)


PARAMETERS = {
    "SIMPLE_RADIAL": ("400 320.5 240.5 -.2", "pinhole", [-0.2, 0, 0, 0]),
    "RADIAL": ("400 320.5 240.5 -.2 .05", "pinhole", [-0.2, 0.05, 0, 0]),
    "OPENCV": ("400 400 320.5 240.5 -.2 .05 .01 .02", "pinhole", [-0.2, 0.05, 0.01, 0.02]),
    "FULL_OPENCV": ("400 400 320.5 240.5 1 2 3 4 5 6 7 8", "pinhole", [1, 2, 3, 4, 5, 6, 7, 8]),
    "RADIAL_FISHEYE": ("400 320.5 240.5 -.2 .05", "fisheye", [-0.2, 0.05, 0, 0]),
    "OPENCV_FISHEYE": ("400 400 320.5 240.5 1 2 3 4", "fisheye", [1, 2, 3, 4]),
    "PINHOLE": ("400 400 320.5 240.5", "pinhole", []),
}


@pytest.mark.parametrize("model", PARAMETERS)
def test_a_lens_of_colmap_whose_pixels_begin_at_their_corner(tmp_path, model):
    numbers, ours, bent = PARAMETERS[model]
    text = f"# Camera list\n #   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n1 {model} 640 480 {numbers}\n"
    found = read_calibration(written(tmp_path, "cameras.txt", text)).lens
    assert (found.fx, found.fy, found.cx, found.cy, found.size) == (400, 400, 320, 240, (640, 480))
    assert (found.model, [*found.distortion]) == (ours, bent)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1 FOV 640 480 1 2 3 4 5", "expected a lens of SIMPLE_PINHOLE"),
        ("1 OPENCV 640 480 1 2 3", "expected 8 parameters of OPENCV, got 3"),
        ("1 PINHOLE 640 480 1 1 2 2\n2 PINHOLE 640 480 1 1 3 3", "expected one lens"),
        ("1 PINHOLE 640.5 480 1 1 2 2", "expected whole pixels of a size, .* got 640.5 480 1 1 2 2: "),
        ("1 PINHOLE 640 480 1 1 x 2", "and numbers, after PINHOLE, got 640 480 1 1 x 2: "),
        ("1", "got none"),
        ("", "got 0"),
    ],
)
def test_what_is_no_lens_of_colmap(tmp_path, text, said):
    with pytest.raises(ClipError, match=said) as caught:
        read_calibration(written(tmp_path, "cameras.txt", text))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["<a", "<a></a>", "<?xml version='1.0'?><opencv_storage></opencv_storage>"])
def test_xml_of_something_else(tmp_path, text):
    with pytest.raises(ClipError, match="expected OpenCV") as caught:
        read_calibration(written(tmp_path, "c.xml", text))
    assert "\n" not in str(caught.value)


def test_the_form_of_scared_and_a_turn_as_a_vector(tmp_path):
    inner = two_eyes(("KL", "DL", "KR", "DR")) | {"R": [0.01, -0.03, 0.02]}
    found = read_calibration(written(tmp_path, "frame.json", {"camera-calibration": inner, "n": 1}))
    assert found.right is not None
    np.testing.assert_allclose(found.right.rotation, TURN, atol=1e-12)


@pytest.mark.parametrize(("model", "ours"), [("radtan", "pinhole"), ("equidistant", "fisheye")])
def test_what_kalibr_writes_in_metres(tmp_path, model, ours):
    eye = KALIBR_EYE.replace("MODEL", model)
    rows = [[*row, shift / 1000] for row, shift in zip(TURN, SHIFT, strict=True)] + [[0.0, 0.0, 0.0, 1.0]]
    pose = "".join(f"  - {row}\n" for row in rows)
    found = read_calibration(written(tmp_path, "camchain.yaml", f"cam0:{eye}cam1:{eye}  T_cn_cnm1:\n{pose}"))
    assert found.lens.model == ours
    assert found.lens.size == SIZE
    assert found.right is not None
    np.testing.assert_allclose(found.right.shift, SHIFT, rtol=1e-12)
    assert read_calibration(written(tmp_path, "one.yaml", f"cam0:{eye}")).right is None


def test_a_board_measured_in_metres(tmp_path):
    values = two_eyes(("M1", "D1", "M2", "D2")) | {"T": [each / 1000 for each in SHIFT]}
    found = read_calibration(written(tmp_path, "eyes.json", values))
    assert found.right is not None
    np.testing.assert_allclose(found.right.shift, SHIFT, rtol=1e-12)


WRONG = {
    "another text": ("hello: [", "in YAML, JSON or XML"),
    "no names": ("12", "got another text"),
    "other names": ({"fps": 25, "who": "x"}, "got fps, who"),
    "no distortion": ({"camera_matrix": MATRIX}, "got no distortion_coefficients"),
    "a small matrix": ({"mtx": [1, 2, 3], "dist": BENT}, "got 3"),
    "a matrix of another scale": (
        {"mtx": [[2 * each for each in row] for row in MATRIX], "dist": BENT}, "got 877, 0, 610.5,"
    ),
    "a transposed matrix": (
        {"mtx": np.transpose(MATRIX).tolist(), "dist": BENT}, "of fx 0 cx, 0 fy cy, 0 0 1, got 438.5, 0, 0"
    ),
    "a skewed matrix": ({"mtx": [[500, 50, 320], *MATRIX[1:]], "dist": BENT}, "got 500, 50, 320"),
    "a size of one number": (
        {"mtx": MATRIX, "dist": BENT, "image_size": [640]}, "width and height of image_size, got 1 numbers"
    ),
    "words": ({"mtx": [["a"] * 3] * 3, "dist": BENT}, "expected numbers of mtx"),
    "no number": ({"mtx": [[float("nan")] * 3] * 3, "dist": BENT}, "finite numbers of mtx"),
    "a number beyond all floats": (
        {"mtx": [[10**400] * 3] * 3, "dist": BENT}, "expected numbers of mtx, got other values"
    ),
    "a size beyond all floats": (
        {"mtx": MATRIX, "dist": BENT, "image_size": [640, 10**400]}, "expected numbers of image_size"
    ),
    "no focal length": ({"mtx": np.diag([0, 1, 1]).tolist(), "dist": BENT}, "fx: expected greater than 0"),
    "three coefficients": ({"mtx": MATRIX, "dist": BENT[:3]}, "0, 4, 5, 8, 12, 14 coefficients"),
    "an unknown model": (ROS.replace("plumb_bob", "omni"), "distortion model of plumb_bob"),
    "no T": ({k: v for k, v in two_eyes(("M1", "D1", "M2", "D2")).items() if k != "T"}, "R and T"),
    "no turn": (two_eyes(("M1", "D1", "M2", "D2")) | {"R": [[1, 0, 0]] * 3}, "expected a rotation"),
    "one place": (two_eyes(("M1", "D1", "M2", "D2")) | {"T": [0, 0, 0]}, "more than 0"),
    "a bomb": ("[" * 100_000, "in YAML, JSON or XML"),
    "kalibr's half": ("cam0: {intrinsics: [1, 2, 3, 4]}", "of cam0, got less"),
}  # fmt: skip


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_no_calibration_is_refused_in_a_line(tmp_path, kind):
    content, said = WRONG[kind]
    path = written(tmp_path, "c.yaml", content)
    with pytest.raises(ClipError, match=re.escape(said)) as caught:
        read_calibration(path)
    assert str(caught.value).endswith(f": {path}")
    assert "\n" not in str(caught.value)


def test_files_that_cannot_be_read_are_refused_in_a_line(tmp_path):
    (tmp_path / "bytes.yml").write_bytes(b"\xff\xfe\x00\x81")
    for name, said in (("none.yml", "cannot read"), ("bytes.yml", "as text"), (".", "cannot read")):
        with pytest.raises(ClipError, match=said):
            read_calibration(tmp_path / name)
