"""Calibrations as programs write them: OpenCV (YAML, XML, JSON), ROS and Kalibr (YAML), COLMAP's cameras.txt,
StereoCalibration.ini."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
import yaml
from pydantic import ValidationError

from renderer.clip import ClipError
from renderer.readers.lenses.calibration import Calibration, LensCalibration, Model, SecondEye, first_fault
from renderer.readers.lenses.colmap_lens import colmap_lens
from renderer.readers.lenses.opencv_xml import opencv_xml
from renderer.readers.lenses.rectification import read_ini
from renderer.regular_files import read_regular

MOST_BYTES: Final = 1 << 20
METRES: Final = 0.1
"""Eyes of an endoscope are 3 to 10 mm apart: a distance below is in metres, as of a board measured so."""
ONE_EYE: Final = (
    ("camera_matrix", "distortion_coefficients"),
    ("camera_matrix", "dist_coeffs"),
    ("camera_matrix", "dist_coeff"),
    ("cameramatrix", "distcoeffs"),
    ("mtx", "dist"),
    ("k", "d"),
)
"""Names of a lens's matrix and of its distortion, in lower case."""
TWO_EYES: Final = (
    (("m1", "d1"), ("m2", "d2")),
    (("k1", "d1"), ("k2", "d2")),
    (("kl", "dl"), ("kr", "dr")),
    (("cameramatrix1", "distcoeffs1"), ("cameramatrix2", "distcoeffs2")),
)
LENSES: Final = (*ONE_EYE, *(left for left, _ in TWO_EYES))
MODELS: Final[Mapping[str, Model]] = {
    "plumb_bob": "pinhole", "rational_polynomial": "pinhole", "radtan": "pinhole", "none": "pinhole",
    "equidistant": "fisheye", "fisheye": "fisheye",
}  # fmt: skip
SIDES: Final = (("image_width", "image_height"), ("width", "height"))
"""Names of the size of the images; the second ones are of ROS's message camera_info."""
SKEW: Final = 1e-3
"""Of the focal length, by which axes of a lens may be off a right angle."""
FORMS: Final = "OpenCV's or ROS's camera_matrix, M1 and M2, or Kalibr's cam0"

Names = Mapping[str, Any]
Pairs = Sequence[tuple[str, str]]


def read_calibration(path: Path) -> Calibration:
    """What the file says.

    Of two eyes the left one is the first; lengths are in mm, and below METRES in metres. OpenCV's stereo
    example writes R and T to a second file: extrinsics.yml beside intrinsics.yml is read with it.

    Raises:
        ClipError: the file cannot be read, or says nothing of a lens, or something that no lens has.
    """
    if path.suffix.lower() == ".ini":
        return read_ini(path)
    try:
        text = _text(path)
        if path.suffix.lower() == ".txt":
            return colmap_lens(text)
        return _of_names(_named(text) | _extrinsic(path))
    except ValidationError as error:
        raise ClipError(f"{first_fault(error)}: {path}") from error
    except UnicodeDecodeError as error:
        raise ClipError(f"expected a calibration as text, got other bytes: {path}") from error
    except ValueError as error:
        raise ClipError(f"{error}: {path}") from error
    except OSError as error:
        raise ClipError(f"cannot read the calibration, {error.strerror or error}: {path}") from error


def _text(path: Path) -> str:
    return read_regular(path, MOST_BYTES).decode().lstrip("\ufeff")


def _extrinsic(path: Path) -> dict[str, Any]:
    """What extrinsics.yml says beside an intrinsics.yml."""
    beside = path.with_name(path.name.replace("intrinsics", "extrinsics"))
    if beside == path or not beside.is_file():
        return {}
    try:
        said = _named(_text(beside), (("r", "t"),))
    except (OSError, ValueError) as error:
        raise ValueError(f"{error} in {beside.name} beside it") from error
    return {name: said[name] for name in ("r", "t") if name in said}


class _Loader(yaml.SafeLoader):  # type: ignore[misc]
    """YAML of plain values, and OpenCV's matrices as the mappings that they are."""


_Loader.add_constructor(
    "tag:yaml.org,2002:opencv-matrix", lambda loader, node: loader.construct_mapping(node, deep=True)
)


def _named(text: str, expected: Pairs = LENSES) -> dict[str, Any]:
    """What a text says by names, in lower case; where a single one holds them all, as SCARED's
    "camera-calibration", what that holds."""
    value = opencv_xml(text) if text.lstrip().startswith("<") else _yaml(text)
    for each in (value, *(inner for inner in value.values() if isinstance(inner, dict))):
        names = {str(name).lower(): said for name, said in each.items()}
        if "cam0" in names or any(first in names for first, _ in expected):
            return names
    raise ValueError(f"expected {FORMS}, got {', '.join(map(str, [*value][:4]))}")


def _yaml(text: str) -> Names:
    """The first document: ROS ends each message with the line that begins another."""
    plain = (line for line in text.splitlines() if not line.startswith("%YAML"))
    try:
        value = next(yaml.load_all("\n".join(plain), _Loader), None)
    except (yaml.YAMLError, RecursionError, ValueError, TypeError, AttributeError) as error:
        raise ValueError("expected a calibration in YAML, JSON or XML, got another text") from error
    if not isinstance(value, dict):
        raise ValueError(f"expected {FORMS}, got another text")
    return value


def _of_names(names: Names) -> Calibration:
    if "cam0" in names:
        return _of_kalibr(names)
    for left, right in TWO_EYES:
        if left[0] in names:
            eye = _second(_lens(names, right), names.get("r"), names.get("t"))
            return Calibration(lens=_lens(names, left), right=eye)
    return Calibration(lens=_lens(names, _convention(names)))


def _convention(names: Names) -> tuple[str, str]:
    held = [each for each in ONE_EYE if each[0] in names]
    return next((each for each in held if each[1] in names), held[0])


def _lens(names: Names, called: tuple[str, str]) -> LensCalibration:
    matrix, distortion = called
    missing = [name for name in called if name not in names]
    if missing:
        raise ValueError(f"expected {matrix} and {distortion}, got no {' and no '.join(missing)}")
    values, bent = _matrix(names[matrix], matrix), _numbers(names[distortion], distortion)
    flagged = "equidistant" if str(names.get("fisheye_model", 0)) == "1" else "plumb_bob"
    return LensCalibration(
        fx=values[0], fy=values[4], cx=values[2], cy=values[5],
        model=_model(names.get("distortion_model", flagged)), distortion=tuple(bent), size=_size(names),
    )  # fmt: skip


def _matrix(value: Any, name: str) -> list[float]:
    """fx 0 cx, 0 fy cy, 0 0 1."""
    values = _numbers(value, name)
    if len(values) != 9:
        raise ValueError(f"expected 3 times 3 numbers of {name}, got {len(values)}")
    _, skew, _, *rest = values
    if abs(skew) > SKEW * abs(values[0]) or not np.allclose([rest[0], *rest[3:]], (0, 0, 0, 1), atol=1e-9):
        got = ", ".join(f"{each:g}" for each in values)
        raise ValueError(f"expected {name} of fx 0 cx, 0 fy cy, 0 0 1, got {got}")
    return values


def _model(told: object) -> Model:
    if str(told).lower() not in MODELS:
        raise ValueError(f"expected a distortion model of {', '.join(MODELS)}, got {told}")
    return MODELS[str(told).lower()]


def _size(names: Names) -> tuple[int, int] | None:
    held = next((sides for sides in SIDES if all(side in names for side in sides)), None)
    if held is not None:
        width, height = (_numbers(names[side], side)[0] for side in held)
        return round(width), round(height)
    return _pair(names, "image_size")


def _pair(names: Names, name: str) -> tuple[int, int] | None:
    """Width and height by one name."""
    if name not in names:
        return None
    size = _numbers(names[name], name)
    if len(size) != 2:
        raise ValueError(f"expected width and height of {name}, got {len(size)} numbers")
    return round(size[0]), round(size[1])


def _second(lens: LensCalibration, turn: Any, shift: Any) -> SecondEye:
    if turn is None or shift is None:
        raise ValueError("expected R and T from the left to the right eye, got none")
    turned, shifted = _numbers(turn, "R"), _numbers(shift, "T")
    if len(turned) == 3:
        turned = [float(each) for each in cv2.Rodrigues(np.array(turned))[0].ravel()]
    unit = 1000.0 if math.hypot(*shifted) < METRES else 1.0
    return SecondEye(lens=lens, turn=tuple(turned), shift=tuple(unit * each for each in shifted))


def _of_kalibr(names: Names) -> Calibration:
    left = _kalibr_lens(names["cam0"], "cam0")
    if "cam1" not in names:
        return Calibration(lens=left)
    right = names["cam1"]
    if not isinstance(right, dict) or "T_cn_cnm1" not in right:
        raise ValueError("expected T_cn_cnm1 of cam1, got none")
    moved = _numbers(right["T_cn_cnm1"], "T_cn_cnm1")
    if len(moved) != 16:
        raise ValueError(f"expected 4 times 4 numbers of T_cn_cnm1, got {len(moved)}")
    pose = np.reshape(moved, (4, 4))
    return Calibration(
        lens=left, right=_second(_kalibr_lens(right, "cam1"), pose[:3, :3], 1000 * pose[:3, 3])
    )


def _kalibr_lens(said: Any, name: str) -> LensCalibration:
    wanted = ("intrinsics", "distortion_coeffs", "distortion_model")
    if not isinstance(said, dict) or any(each not in said for each in wanted):
        raise ValueError(f"expected {', '.join(wanted)} of {name}, got less")
    if said.get("camera_model", "pinhole") != "pinhole":
        raise ValueError(f"expected a pinhole camera model of {name}, got {said['camera_model']}")
    inner = _numbers(said["intrinsics"], "intrinsics")
    if len(inner) != 4:
        raise ValueError(f"expected 4 intrinsics of {name}, got {len(inner)}")
    return LensCalibration(
        fx=inner[0], fy=inner[1], cx=inner[2], cy=inner[3], model=_model(said["distortion_model"]),
        distortion=tuple(_numbers(said["distortion_coeffs"], "distortion_coeffs")),
        size=_pair(said, "resolution"),
    )  # fmt: skip


def _numbers(value: Any, name: str) -> list[float]:
    """Those of a list, of lists within it, or of a mapping with "data"."""
    inner = value.get("data") if isinstance(value, dict) else value
    try:
        numbers = np.asarray(inner, dtype=np.float64).ravel()
    except (ValueError, TypeError, OverflowError, RecursionError) as error:
        raise ValueError(f"expected numbers of {name}, got other values") from error
    if not numbers.size or not np.isfinite(numbers).all():
        raise ValueError(f"expected finite numbers of {name}, got others")
    return [float(each) for each in numbers]
