"""Keyframes of SCARED (Allan et al., 2021) as their preprocessing leaves them: read and written."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from renderer.budget import OverBudget
from renderer.camera import Camera, FloatArray
from renderer.clip import BoolImage, ByteImage, Clip, ClipError, Frame
from renderer.json_files import read_json
from renderer.readers.clip_files import ClipFiles, files_in, pictures_of
from renderer.readers.geometry.depth_maps import DepthMap, read_map, within
from renderer.readers.geometry.poses import nearest_rotations
from renderer.readers.image_files.picture_files import require_size
from renderer.readers.image_files.pictures import common_size, read_rgb
from renderer.readers.new_clip import Known, new_clip
from renderer.readers.numbered_files import beside, numbered, strays
from renderer.regular_files import read_whole

NEAREST, FARTHEST = 30.0, 300.0
"""Depth in mm outside of which it is no measurement, as EndoSurf takes it (Zha et al., MICCAI 2023)."""

FIELD_STEPS = {1: 2, 2: 1, 3: 4, 6: 8, 7: 8}
"""The field keeps one frame in so many of each dataset."""

BASELINE = 4.2
"""Between the eyes of the endoscope of keyframes written here, mm."""

_PICTURES, _POSES, _MATRICES = "left_finalpass", "frame_data", "reprojection_data"
_DISPARITY, _POINTS = "disparity", "scene_points"
_CLOUD_STEP = 4  # px between points of point_cloud.obj


def is_scared(path: Path) -> bool:
    """Whether the folder is a keyframe, or the data/ of one."""
    return any((folder / _POSES).is_dir() for folder in (path, path / "data"))


def scared_files(path: Path) -> ClipFiles:
    """What a keyframe is read from; scene_points/ too where disparity/ is preferred."""
    data = _data(path)
    told = [file for name in (_POSES, _MATRICES) for file in files_in(data / name) if _is_json(file)]
    maps = pictures_of(data, (_DISPARITY, _POINTS))
    return ClipFiles(pictures_of(data, [_PICTURES]), (*told, *maps))


def usual_step(path: Path) -> int:
    """The field keeps one frame in so many of the keyframe at `path`, by the folder dataset_N above it."""
    numbers = (re.fullmatch(r"dataset_(\d+)", part) for part in reversed(path.resolve().parts))
    return next((FIELD_STEPS.get(int(found[1]), 1) for found in numbers if found), 1)


def open_scared(path: Path) -> Clip:
    """Opens a keyframe: left_finalpass/, frame_data/, reprojection_data/ and, for depth, disparity/.

    Intrinsics are those of the rectified pictures, by Q of reprojection_data/: focal length Q[2,3],
    principal point (-Q[0,3], -Q[1,3]) from the centre of the first pixel, baseline |1 / Q[3,2]|. Depth
    is focal length * baseline / disparity. Without disparity/, the left half of scene_points/ (mm, in
    camera axes) is projected with these intrinsics as it stands, the nearest point of a pixel wins;
    the rectifying rotation is left out, as the field does. Depth outside of [NEAREST, FARTHEST] is no
    measurement.

    The matrices of frame_data/ are world-to-camera; the first camera is made the world. There are no
    tool masks: both masks are the measured pixels closed by a square of 1/128 of the width, and what is
    closed stays without depth. All frames are read: `usual_step` says which of them the field keeps.

    Raises:
        ClipError: parts that are missing or do not agree, or matrices that are none.
    """
    data = _data(path)
    images = numbered(data / _PICTURES)
    lenses = tuple(_lens(file) for file in beside(images, data / _MATRICES, _is_json))
    poses, mended = _poses(beside(images, data / _POSES, _is_json))
    folder = next((name for name in (_DISPARITY, _POINTS) if (data / name).is_dir()), None)
    depth = beside(images, data / folder) if folder else ()
    size = common_size((*images.values(), *(depth if folder == _DISPARITY else ())))
    from_first = np.linalg.inv(poses[0])
    cameras = tuple(
        Camera(lens.focal, lens.focal, lens.cx, lens.cy, *size, pose @ from_first)
        for lens, pose in zip(lenses, poses, strict=True)
    )
    reader = _Reader(tuple(images.values()), depth, folder == _POINTS, lenses, cameras)
    loose = strays(images, data / _PICTURES) + (strays(images, data / folder) if folder else [])
    clip = new_clip(
        path,
        "scared",
        cameras=cameras,
        labels=tuple(entry.name for entry in images.values()),
        read_image=reader.image,
        known=reader.known,
        has_depth=bool(depth),
        unit="mm",
        notices=(*loose, *mended, *_said_of_depth(folder)),
    )
    return replace(clip, name=_name(data), baseline=lenses[0].baseline)


@dataclass(frozen=True)
class _Lens:
    """What Q says: px, px, px, mm and px."""

    focal: float
    cx: float
    cy: float
    baseline: float
    apart: float
    """Between the principal points of the eyes: what disparities lack."""


@dataclass(frozen=True, eq=False)
class _Reader:
    images: tuple[Path, ...]
    depth_files: tuple[Path, ...]
    depth_is_points: bool
    lenses: tuple[_Lens, ...]
    cameras: tuple[Camera, ...]

    def image(self, index: int) -> ByteImage:
        return read_rgb(self.images[index])

    def depth(self, index: int) -> DepthMap | None:
        if not self.depth_files:
            return None
        path, lens, camera = self.depth_files[index], self.lenses[index], self.cameras[index]
        if self.depth_is_points:
            return within(_nearest(_left_points(path, camera.height), camera), NEAREST, FARTHEST)
        disparity = read_map(path)
        known = np.where(disparity > 0, disparity + np.float32(lens.apart), np.inf)
        depth = (lens.focal * lens.baseline / known).astype(np.float32)
        return within(depth, NEAREST, FARTHEST)

    def known(self, index: int) -> Known:
        depth = self.depth(index)
        return Known() if depth is None else Known(_closed(depth > 0), depth=depth)


def _data(path: Path) -> Path:
    return path if (path / _POSES).is_dir() else path / "data"


def _name(data: Path) -> str:
    """keyframe_1, and what dataset it is of where the folders say so."""
    whole = data.resolve()
    keyframe = whole.parent if whole.name == "data" else whole
    known = re.fullmatch(r"dataset_\d+", keyframe.parent.name)
    return f"{keyframe.parent.name}-{keyframe.name}" if known else keyframe.name


def _said_of_depth(folder: str | None) -> list[str]:
    return {
        _DISPARITY: [],
        _POINTS: ["depth is read from scene_points/, projected without the rectifying rotation"],
        None: ["no disparity/ and no scene_points/: no measured depth"],
    }[folder]


def _is_json(path: Path) -> bool:
    return path.suffix == ".json" and not path.name.startswith(".")


def _matrix(path: Path, name: str) -> FloatArray:
    """The finite (4, 4) matrix that a JSON file holds under `name`."""
    try:
        matrix = np.array(read_json(path)[name], dtype=np.float64)
    except (ValueError, KeyError, TypeError) as error:
        raise ClipError(f"expected {name} in a JSON file, got none that can be read: {path}") from error
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        raise ClipError(f"expected {name} to be a finite 4x4 matrix, got shape {matrix.shape}: {path}")
    return matrix


def _lens(path: Path) -> _Lens:
    q = _matrix(path, "reprojection-matrix")
    if q[2, 3] <= 0 or q[3, 2] == 0:
        given = f"Q[2,3] = {q[2, 3]:g} and Q[3,2] = {q[3, 2]:g}"
        raise ClipError(f"expected a focal length above 0 and a baseline in Q, got {given}: {path}")
    # OpenCV counts from the centre of the first pixel, which here is at 0.5.
    baseline, apart = float(abs(1 / q[3, 2])), float(q[3, 3] / q[3, 2])
    return _Lens(float(q[2, 3]), float(0.5 - q[0, 3]), float(0.5 - q[1, 3]), baseline, apart)


def _poses(paths: Sequence[Path]) -> tuple[FloatArray, tuple[str, ...]]:
    """World-to-camera matrices (N, 4, 4), and what was mended of them."""
    poses = np.stack([_matrix(path, "camera-pose") for path in paths])
    last = np.abs(poses[:, 3] - (0, 0, 0, 1)).max(axis=1)
    if last.max() > 1e-6:
        worst = paths[int(np.argmax(last))]
        raise ClipError(
            f"expected camera-pose to be a rotation and a translation above 0 0 0 1, got another: {worst}"
        )
    try:
        spins = nearest_rotations(poses[:, :3, :3], [path.name for path in paths])
    except ValueError as error:
        raise ClipError(f"camera-pose: {error}: {paths[0].parent}") from error
    poses[:, :3, :3] = spins.matrices
    return poses, tuple(f"{_POSES}/: {said}" for said in spins.notices)


def _left_points(path: Path, height: int) -> FloatArray:
    """(height, W, 3) x y z in mm: the upper half of a TIFF that holds both eyes, or the whole of one."""
    try:
        require_size(path)
        stored = cv2.imdecode(np.frombuffer(read_whole(path), np.uint8), cv2.IMREAD_UNCHANGED)
    except OverBudget as error:
        raise ClipError(f"{error}: {path}") from error
    except (OSError, cv2.error) as error:
        raise ClipError(f"expected a TIFF of points, got a damaged file: {path}") from error
    if (
        stored is None
        or stored.ndim != 3
        or stored.shape[2] != 3
        or stored.shape[0] not in (height, 2 * height)
    ):
        got = "no image" if stored is None else f"shape {stored.shape}"
        raise ClipError(f"expected points of shape ({2 * height}, width, 3), got {got}: {path}")
    return stored[:height, :, ::-1].astype(np.float64)  # OpenCV hands over the channels in reverse.


def _nearest(points: FloatArray, camera: Camera) -> DepthMap:
    """Depth (H, W) of points (..., 3) in camera axes, the nearest in each pixel; 0 where none falls."""
    seen = points[np.isfinite(points).all(axis=-1) & (points[..., 2] > 0)]
    places, z = camera.moved(np.eye(4)).project(seen)
    columns, rows = np.floor(places).astype(np.int64).T
    inside = (columns >= 0) & (columns < camera.width) & (rows >= 0) & (rows < camera.height)
    depth = np.full((camera.height, camera.width), np.inf, dtype=np.float32)
    np.minimum.at(depth, (rows[inside], columns[inside]), z[inside].astype(np.float32))
    return np.where(np.isfinite(depth), depth, np.float32(0))


def _closed(measured: BoolImage) -> BoolImage:
    """Morphological closing by a square of 1/128 of the width: small holes and gaps are filled."""
    side = max(1, round(measured.shape[1] / 128))
    square, middle = np.ones((side, side), np.uint8), side // 2
    grown = cv2.dilate(measured.astype(np.uint8), square, anchor=(middle, middle))
    # The mirrored square: one of even side has no middle, and would shift what it closes.
    mirrored = (side - 1 - middle, side - 1 - middle)
    return np.asarray(cv2.erode(grown, square, anchor=mirrored) > 0)


def write_scared(folder: Path, frames: Iterable[Frame]) -> None:
    """Writes frames that have depth into `folder`: data/ with poses, left pictures, Q and disparity.

    Poses are world-to-camera in millimetres; disparity is focal * baseline / depth in pixels,
    0 = none. Principal points count from the centre of the first pixel, as OpenCV's calibration
    does. The layout has no tool masks: tools have no disparity.

    Raises:
        ClipError: a frame without depth.
        OSError: the folder cannot be written.
    """
    data = folder / "data"
    for name in ("frame_data", "left_finalpass", "reprojection_data", "disparity"):
        (data / name).mkdir(parents=True, exist_ok=True)
    for frame in frames:
        if frame.depth is None:
            raise ClipError(f"expected depth in every frame, frame {frame.index} has none: {folder}")
        name = f"frame_data{frame.index:06d}"
        camera = frame.camera
        _write_json(data / "frame_data" / f"{name}.json", _calibration(camera))
        q = {"reprojection-matrix": _reprojection(camera).tolist()}
        _write_json(data / "reprojection_data" / f"{name}.json", q)
        Image.fromarray(frame.image).save(data / "left_finalpass" / f"{name}.png")
        measured = frame.depth > 0
        disparity = np.where(measured, camera.fx * BASELINE / np.where(measured, frame.depth, 1), 0)
        Image.fromarray(disparity.astype(np.float32)).save(data / "disparity" / f"{name}.tiff")
        if frame.index == 0:
            _write_cloud(folder / "point_cloud.obj", frame, frame.depth)


def _calibration(camera: Camera) -> dict[str, object]:
    matrix = camera.intrinsics
    matrix[:2, 2] -= 0.5
    eyes = {
        "KL": matrix.tolist(), "KR": matrix.tolist(), "DL": [[0.0] * 5], "DR": [[0.0] * 5],
        "R": np.eye(3).tolist(), "T": [[-BASELINE], [0.0], [0.0]],
    }  # fmt: skip
    return {"camera-calibration": eyes, "camera-pose": camera.camera_from_world.tolist()}


def _reprojection(camera: Camera) -> NDArray[np.float64]:
    """OpenCV's Q: (column, row, disparity, 1) to homogeneous (x, y, z) in mm."""
    q = np.zeros((4, 4))
    q[0, 0] = q[1, 1] = 1
    q[0, 3], q[1, 3], q[2, 3] = 0.5 - camera.cx, 0.5 - camera.cy, camera.fx
    q[3, 2] = 1 / BASELINE
    return q


def _write_cloud(path: Path, frame: Frame, depth: NDArray[np.float32]) -> None:
    grid = (slice(None, None, _CLOUD_STEP), slice(None, None, _CLOUD_STEP))
    measured = depth[grid] > 0
    points = frame.camera.unproject(depth)[grid][measured]
    colors = frame.image[grid][measured] / 255
    np.savetxt(path, np.hstack([points, colors]), fmt="v %.4f %.4f %.4f %.3f %.3f %.3f")


def _write_json(path: Path, values: dict[str, object]) -> None:
    path.write_text(json.dumps(values, indent=1), encoding="utf-8")
