"""The calibration of a stereo endoscope, StereoCalibration.ini, and the camera of its rectified pictures."""

from __future__ import annotations

import configparser
from pathlib import Path

from pydantic import ValidationError

from renderer.clip import ClipError
from renderer.readers.lenses.calibration import Calibration, LensCalibration, SecondEye, first_fault
from renderer.readers.lenses.straightening import Rectified, rectified
from renderer.regular_files import read_whole


def read_rectified(path: Path, size: tuple[int, int]) -> Rectified:
    """What rectified pictures of `size` (width, height) were taken with.

    The file is as `read_ini` reads it. Rectified is as the preprocessing of StereoMIS does: OpenCV's
    stereoRectify with alpha 0 and no disparity at infinity.

    Raises:
        ClipError: the file is missing or incomplete, or its pictures have another shape.
    """
    calibration = read_ini(path)
    try:
        return rectified(calibration, size)
    except ValueError as error:
        raise ClipError(f"{error}: {path}") from error


def read_ini(path: Path) -> Calibration:
    """The sections StereoLeft and StereoRight with res_x res_y fc_x fc_y cc_x cc_y kc_0 ..., and R_0 ... R_8,
    T_0 ... T_2 from the left to the right eye, in mm.

    Raises:
        ClipError: the file is missing or incomplete, or says what no eyes have.
    """
    values = _sections(path)
    try:
        left, right = _eye(values["StereoLeft"]), _eye(values["StereoRight"])
        turn, shift = _numbers(values["StereoRight"], "R", 9), _numbers(values["StereoRight"], "T", 3)
        return Calibration(lens=left, right=SecondEye(lens=right, turn=turn, shift=shift))
    except ValidationError as error:
        raise ClipError(f"{first_fault(error)}: {path}") from error
    except KeyError as error:
        raise ClipError(f"expected a stereo calibration, got one without {error}: {path}") from error
    except (ValueError, OverflowError) as error:
        raise ClipError(f"expected a stereo calibration of numbers ({error}): {path}") from error


def _sections(path: Path) -> configparser.ConfigParser:
    values = configparser.ConfigParser(strict=False, interpolation=None)
    try:
        values.read_string(read_whole(path).decode(errors="replace"))
    except (OSError, configparser.Error) as error:
        raise ClipError(f"expected a calibration of the form NAME = VALUE, got none: {path}") from error
    return values


def _eye(section: configparser.SectionProxy) -> LensCalibration:
    fx, fy, cx, cy = (float(section[name]) for name in ("fc_x", "fc_y", "cc_x", "cc_y"))
    bent = _numbers(section, "kc", 8 if "kc_7" in section else 5)
    size = round(float(section["res_x"])), round(float(section["res_y"]))
    return LensCalibration(fx=fx, fy=fy, cx=cx, cy=cy, distortion=bent, size=size)


def _numbers(section: configparser.SectionProxy, name: str, count: int) -> tuple[float, ...]:
    """The values NAME_0, NAME_1, ... of a section."""
    return tuple(float(section[f"{name}_{place}"]) for place in range(count))
