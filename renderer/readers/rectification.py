"""The calibration of a stereo endoscope, StereoCalibration.ini, and the camera of its rectified pictures."""

from __future__ import annotations

import configparser
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.clip import ClipError
from renderer.regular_files import read_whole


@dataclass(frozen=True)
class Rectified:
    """What rectified pictures were taken with."""

    camera: Camera
    """Of the left eye."""
    baseline: float
    """Between the eyes, in the unit of the calibration: mm."""


@dataclass(frozen=True, eq=False)
class _Eye:
    matrix: FloatArray
    """(3, 3) at full size, principal point from the centre of the first pixel."""
    distortion: FloatArray
    """(5 to 8,) in OpenCV's order."""
    size: tuple[int, int]


def read_rectified(path: Path, size: tuple[int, int]) -> Rectified:
    """The left camera and the baseline of rectified pictures of `size` (width, height).

    The file has the sections StereoLeft and StereoRight with res_x res_y fc_x fc_y cc_x cc_y kc_0 ...,
    and R_0 ... R_8, T_0 ... T_2 from the left to the right eye. Rectified is as the preprocessing of
    StereoMIS does: OpenCV's stereoRectify with alpha 0 and no disparity at infinity.

    Raises:
        ClipError: the file is missing or incomplete, or its pictures have another shape.
    """
    values = _sections(path)
    try:
        left, right = _eye(values["StereoLeft"]), _eye(values["StereoRight"])
        turn = _numbers(values["StereoRight"], "R", 9).reshape(3, 3)
        shift = _numbers(values["StereoRight"], "T", 3)[:, None]
    except (KeyError, ValueError) as error:
        raise ClipError(f"expected a stereo calibration, got one without {error}: {path}") from error
    width, height = left.size
    if not shift.any() or min(width, height, left.matrix[0, 0], right.matrix[0, 0]) <= 0:
        raise ClipError(f"expected sizes, focal lengths and a baseline above 0, got others: {path}")
    if abs(width * size[1] - height * size[0]) > 0.005 * width * size[1]:
        of = f"{width}x{height}, the images are {size[0]}x{size[1]}"
        raise ClipError(f"expected the calibration of such images, got one of {of}: {path}")
    lenses = left.matrix, left.distortion, right.matrix, right.distortion
    flags = cv2.CALIB_ZERO_DISPARITY
    new_left, new_right = cv2.stereoRectify(*lenses, left.size, turn, shift, flags=flags, alpha=0)[2:4]
    # OpenCV counts from the centre of the first pixel, which here is at 0.5.
    focal, cx, cy = float(new_left[0, 0]), float(new_left[0, 2]) + 0.5, float(new_left[1, 2]) + 0.5
    camera = Camera(focal, focal, cx, cy, width, height).resized(*size)
    return Rectified(camera, float(abs(new_right[0, 3] / new_right[0, 0])))


def _sections(path: Path) -> configparser.ConfigParser:
    values = configparser.ConfigParser(strict=False, interpolation=None)
    try:
        values.read_string(read_whole(path).decode(errors="replace"))
    except (OSError, configparser.Error) as error:
        raise ClipError(f"expected a calibration of the form NAME = VALUE, got none: {path}") from error
    return values


def _eye(section: configparser.SectionProxy) -> _Eye:
    fx, fy, cx, cy = (float(section[name]) for name in ("fc_x", "fc_y", "cc_x", "cc_y"))
    count = 8 if "kc_7" in section else 5
    size = round(float(section["res_x"])), round(float(section["res_y"]))
    matrix = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    return _Eye(matrix, _numbers(section, "kc", count), size)


def _numbers(section: configparser.SectionProxy, name: str, count: int) -> FloatArray:
    """The values NAME_0, NAME_1, ... of a section."""
    numbers = np.array([float(section[f"{name}_{place}"]) for place in range(count)])
    if not np.isfinite(numbers).all():
        raise ValueError(f"finite {name}")
    return numbers
