"""Writes the SCARED layout (Allan et al., 2021) as its preprocessing leaves a keyframe."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from renderer.camera import Camera
from renderer.clip import ClipError, Frame

BASELINE = 4.2
"""Between the eyes of the endoscope, mm."""

_CLOUD_STEP = 4  # px between points of point_cloud.obj


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
