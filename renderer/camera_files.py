"""Cameras of other programs: cameras.json of 3D Gaussian Splatting, transforms.json of NeRF, COLMAP's."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera, whole_pixels
from renderer.json_files import read_json
from renderer.readers.geometry.poses import pose_matrix
from renderer.regular_files import read_regular

FROM_OPENGL: Final = np.diag([1.0, -1.0, -1.0, 1.0])
"""Cameras of transforms.json look along -z, with y up."""
PINHOLES: Final = {"SIMPLE_PINHOLE": (0, 0, 1, 2), "PINHOLE": (0, 1, 2, 3)}
"""COLMAP's models without distortion: places of fx, fy, cx, cy among their numbers."""
DISTORTION = ("k1", "k2", "k3", "k4", "p1", "p2")
"""Numbers of a transforms.json that bend the image; 0 where the lens is straight."""
STRAIGHT: Final = ("PINHOLE", "SIMPLE_PINHOLE", "PERSPECTIVE", "SIMPLE_RADIAL", "RADIAL", "OPENCV")
"""Models of a transforms.json that are pinholes where these numbers are 0."""
LEAST_SHIFT: Final = 0.01
"""Pixels between the principal point and the middle that are worth a word."""


class CameraFileError(ValueError):
    """What was expected, what came, and where."""


@dataclass(frozen=True)
class NamedCamera:
    """A camera by the name of its frame."""

    name: str
    camera: Camera


def read_cameras(path: Path) -> tuple[NamedCamera, ...]:
    """One camera (`Camera.to_json`), or those of another program's file; of COLMAP, a folder with images.txt.

    Raises:
        CameraFileError: no such file, or none of these; names it.
    """
    try:
        if path.is_dir():
            return _of_colmap(path)
        return _of_json(read_json(path), path.stem)
    except OSError as error:
        raise CameraFileError(
            f"cannot read the camera file, {error.strerror}: {error.filename or path}"
        ) from error
    except (ValueError, LookupError, TypeError, ArithmeticError, AttributeError) as error:
        text = _told(error)
        said = text if text.startswith("expected") else f"expected a camera or several, got {text}"
        raise CameraFileError(f"{said}: {path}") from error


def _told(error: Exception) -> str:
    if isinstance(error, KeyError):
        return f"no {error}"
    if isinstance(error, json.JSONDecodeError):
        return f"text that is no JSON ({error})"
    return "too few words in a line" if isinstance(error, IndexError) else str(error)


def splatting_json(cameras: Sequence[NamedCamera]) -> bytes:
    """cameras.json as 3D Gaussian Splatting writes it: pose of the camera in the world, focal lengths in px.

    Besides, cx and cy: programs that have no principal point leave them, and take the middle of the picture.
    """
    return json.dumps([_splatting(place, one) for place, one in enumerate(cameras)], indent=1).encode()


def transforms_json(cameras: Sequence[NamedCamera], times: Sequence[float]) -> bytes:
    """transforms.json as NeRF programs read it: poses of cameras that look along -z with y up, the lens of
    each frame in pixels, and its time in [0, 1], which those for moving scenes read."""
    told = [_transforms(one, time) for one, time in zip(cameras, times, strict=True)]
    return json.dumps({"camera_model": "PINHOLE", "frames": told}, indent=1).encode()


def off_center(cameras: Sequence[NamedCamera]) -> str | None:
    """What is to be said where a program that has no principal point shifts the picture."""
    away = max((_shift(one.camera) for one in cameras), default=0.0)
    if away < LEAST_SHIFT:
        return None
    return (
        f"the principal point is up to {away:.2f} px off the centre: cx and cy are given, and programs that "
        "do not read them shift the image"
    )


def _shift(camera: Camera) -> float:
    return math.hypot(camera.cx - camera.width / 2, camera.cy - camera.height / 2)


def _splatting(place: int, one: NamedCamera) -> dict[str, Any]:
    camera, pose = one.camera, one.camera.world_from_camera
    return {
        "id": place,
        "img_name": one.name,
        "width": camera.width,
        "height": camera.height,
        "position": pose[:3, 3].tolist(),
        "rotation": pose[:3, :3].tolist(),
        "fy": camera.fy,
        "fx": camera.fx,
        "cx": camera.cx,
        "cy": camera.cy,
    }


def _transforms(one: NamedCamera, time: float) -> dict[str, Any]:
    camera = one.camera
    return {
        "file_path": one.name,
        "time": time,
        "w": camera.width,
        "h": camera.height,
        "fl_x": camera.fx,
        "fl_y": camera.fy,
        "cx": camera.cx,
        "cy": camera.cy,
        "transform_matrix": (camera.world_from_camera @ FROM_OPENGL).tolist(),
    }


def _of_json(content: Any, name: str) -> tuple[NamedCamera, ...]:
    if isinstance(content, list):
        found = _each(content, _of_splatting)
    elif isinstance(content, dict) and "frames" in content:
        if not isinstance(content["frames"], list):
            raise ValueError(f"{_short(content['frames'])} as frames, where a list is needed")
        found = _each(content["frames"], lambda frame: _of_transforms(content | frame))
    elif not isinstance(content, dict):
        raise ValueError(_short(content))
    else:
        found = (NamedCamera(name, Camera.from_json(content)),)
    if not found:
        raise ValueError("none")
    return found


def _each(
    entries: Sequence[Any], read: Callable[[Any], NamedCamera], kind: type = dict
) -> tuple[NamedCamera, ...]:
    """Of entries of one kind. Raises ValueError: one cannot be read; says which, counted from 0."""
    found = []
    for place, entry in enumerate(entries):
        try:
            if not isinstance(entry, kind):
                raise ValueError(_short(entry))
            found.append(read(entry))
        except (ValueError, LookupError, TypeError, ArithmeticError, AttributeError) as error:
            raise ValueError(f"{_told(error)} in camera {place}") from error
    return tuple(found)


def _number(entry: dict[str, Any], name: str, otherwise: float | None = None) -> float:
    """Raises KeyError or ValueError: it is not there, or none."""
    value = entry[name] if otherwise is None else entry.get(name, otherwise)
    try:
        return float(value)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{_short(value)} as {name}, where a number is needed") from error


def _numbers(entry: dict[str, Any], name: str, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Raises KeyError or ValueError: it is not there, or of another shape."""
    try:
        return np.array(entry[name], float).reshape(shape)
    except (TypeError, ValueError) as error:
        size = " times ".join(map(str, shape))
        raise ValueError(f"{_short(entry[name])} as {name}, where {size} numbers are needed") from error


def _short(value: object) -> str:
    return json.dumps(value)[:40]


def _of_splatting(entry: dict[str, Any]) -> NamedCamera:
    """Where no principal point is given, it is the middle."""
    width, height = (whole_pixels(entry[name], name) for name in ("width", "height"))
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = _numbers(entry, "rotation", (3, 3)), _numbers(entry, "position", (3,))
    cx, cy = _number(entry, "cx", width / 2), _number(entry, "cy", height / 2)
    lens = Camera(_number(entry, "fx"), _number(entry, "fy"), cx, cy, width, height)
    return NamedCamera(str(entry["img_name"]), lens.moved(_inverse(pose)))


def _of_transforms(entry: dict[str, Any]) -> NamedCamera:
    """Numbers of the lens may be the file's or the frame's own."""
    if any(float(entry.get(name) or 0) != 0 for name in DISTORTION):
        raise ValueError(f"a lens with distortion ({', '.join(DISTORTION)}), where one without is needed")
    model = str(entry.get("camera_model") or STRAIGHT[0])
    if model.upper() not in STRAIGHT or entry.get("is_fisheye"):
        got = "fisheye" if entry.get("is_fisheye") else model
        raise ValueError(f"a lens of the model {got[:40]}, where {STRAIGHT[0]} is needed")
    width, height = (whole_pixels(entry[name], name) for name in ("w", "h"))
    focals = _focal(entry, "x", width), _focal(entry, "y", height)
    known = [focal for focal in focals if focal is not None]
    if not known:
        raise KeyError("fl_x")
    # Pixels are square where one of the two is not given.
    fx, fy = (known[0] if focal is None else focal for focal in focals)
    cx, cy = _number(entry, "cx", width / 2), _number(entry, "cy", height / 2)
    lens = Camera(fx, fy, cx, cy, width, height)
    pose = _numbers(entry, "transform_matrix", (4, 4)) @ FROM_OPENGL
    return NamedCamera(Path(str(entry["file_path"])).stem, lens.moved(_inverse(pose)))


def _focal(entry: dict[str, Any], axis: str, pixels: int) -> float | None:
    """In pixels, as it is, or of the field of view in radians along an axis of so many; None: not given."""
    if f"fl_{axis}" in entry:
        return _number(entry, f"fl_{axis}")
    name = f"camera_angle_{axis}"
    if entry.get(name) is None:
        return None
    angle = _number(entry, name)
    if not 0 < angle < math.pi:
        raise ValueError(f"{angle:g} as {name}, where radians between 0 and pi are needed")
    return pixels / 2 / math.tan(angle / 2)


def _of_colmap(folder: Path) -> tuple[NamedCamera, ...]:
    lenses = {words[0]: _lens(words) for words in _lines(folder / "cameras.txt")}
    poses = _lines(folder / "images.txt", every=2)
    if not poses:
        raise ValueError("no image in images.txt")
    return _each(poses, lambda words: _of_image(words, lenses), list)


def _lines(path: Path, every: int = 1) -> list[list[str]]:
    """Words of every first of so many lines that are no comments; points of an image may be an empty line."""
    text = read_regular(path).decode()
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    return [line.split() for line in lines[::every] if line.strip()]


def _lens(words: list[str]) -> Camera:
    if words[1] not in PINHOLES:
        raise ValueError(f"the model {words[1]}, where {' or '.join(PINHOLES)} has no distortion")
    fx, fy, cx, cy = (float(words[4:][place]) for place in PINHOLES[words[1]])
    return Camera(fx, fy, cx, cy, int(words[2]), int(words[3]))


def _of_image(words: list[str], lenses: dict[str, Camera]) -> NamedCamera:
    matrix = pose_matrix(np.array(words[5:8], float), np.array([*words[2:5], words[1]], float))
    # A name may have blanks: it is all that is left of the line.
    return NamedCamera(Path(" ".join(words[9:])).stem, lenses[words[8]].moved(matrix))


def _inverse(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    if pose.shape != (4, 4) or not np.isfinite(pose).all() or abs(np.linalg.det(pose)) < 1e-12:
        raise ValueError("a pose that is not a rotation and a position")
    return np.asarray(np.linalg.inv(pose))
