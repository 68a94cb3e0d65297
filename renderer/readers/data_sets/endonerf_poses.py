"""The cameras of an EndoNeRF folder: poses_bounds.npy, and which axes and which lens its numbers mean."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.clip import ClipError
from renderer.readers.geometry.poses import nearest_rotations
from renderer.readers.image_files.picture_files import read_npy

POSES = "poses_bounds.npy"

Matrix = NDArray[np.float64]
LensOf = Callable[[Matrix, tuple[int, int], Path], tuple[Camera, list[str]]]
"""The lens that three numbers of a row say for images of a size (width, height), and what is worth saying of
it; the path is that of the file, for errors."""


def load_poses(path: Path) -> Matrix:
    """(frames, 17): of each a matrix (3, 5), the pose and three numbers of the lens, and two bounds of depth.

    Raises:
        ClipError: the file is missing, or of another shape, or its matrices are not finite.
    """
    if not path.is_file():
        way = f"copy it there, or name {path.parent / 'images'}, images without depth"
        raise ClipError(f"expected {POSES} with the camera poses, got no such file; {way}: {path}")
    try:
        rows = read_npy(path)
    except (OSError, ValueError) as error:
        raise ClipError(f"expected a numpy array of poses, got an unreadable file: {path}") from error
    if rows.ndim != 2 or rows.shape[1] != 17 or rows.dtype.kind not in "fiu":
        raise ClipError(f"expected poses of shape (frames, 17), got {rows.dtype} {rows.shape}: {path}")
    if not np.isfinite(rows[:, :15]).all():
        raise ClipError(f"expected finite poses, got NaN or infinity: {path}")
    return np.asarray(rows, dtype=np.float64)


def sized_lens(said: Matrix, size: tuple[int, int], path: Path) -> tuple[Camera, list[str]]:
    """By height, width and focal length in px, at the size of the images."""
    width, height = size
    said_height, said_width, focal = (float(value) for value in said)
    if min(said_height, said_width, focal) <= 0:
        raise ClipError(f"expected positive height, width and focal length, got {tuple(said)}: {path}")
    camera = Camera(focal, focal, width / 2, height / 2, width, height)
    if (said_height, said_width) == (height, width):
        return camera, []
    text = f"{POSES} says {said_width:g}x{said_height:g}, the images are {width}x{height}"
    across, down = width / said_width, height / said_height
    whole = said_height.is_integer() and said_width.is_integer()
    if not whole or abs(across / down - 1) >= 0.005:
        raise ClipError(f"{text}: {path}")
    scaled = replace(camera, fx=focal * across, fy=focal * down)
    return scaled, [f"{text}: focal length scaled by {across:g}"]


def cameras_of(
    rows: Matrix, size: tuple[int, int], convention: str, path: Path, lens_of: LensOf
) -> tuple[tuple[Camera, ...], list[str]]:
    """The camera of each row, and what is worth saying of them.

    Raises:
        ClipError: matrices that are no rotations, or numbers that no lens has.
    """
    matrices = rows[:, :15].reshape(-1, 3, 5)
    poses = _to_opencv(matrices[:, :, :4], convention)
    try:
        spins = nearest_rotations(poses[:, :, :3], [f"row {index}" for index in range(len(rows))])
    except ValueError as error:
        raise ClipError(f"{error}: {path}") from error
    poses[:, :, :3] = spins.matrices
    lenses, notices = _lenses(matrices[:, :, 4], size, path, lens_of)
    notices += [f"{POSES}: {said}" for said in spins.notices]
    if np.abs(poses - _to_opencv(np.eye(3, 4)[None], convention)).max() > 1e-9:
        notices.append(f"the camera moves or is rotated: poses read as {convention} camera-to-world")
    square = np.tile(np.eye(4), (len(rows), 1, 1))
    square[:, :3] = poses
    moved = zip(lenses, square, strict=True)
    return tuple(lens.moved(np.linalg.inv(pose).astype(np.float64)) for lens, pose in moved), notices


def _to_opencv(poses: Matrix, convention: str) -> Matrix:
    """Camera-to-world (N, 3, 4) with columns right, down, forward, centre."""
    right, second, third, centre = np.moveaxis(poses, 2, 0)
    columns = {
        "opencv": (right, second, third, centre),
        "opengl": (right, -second, -third, centre),  # Columns: right, up, backward.
        "llff": (second, right, -third, centre),  # Columns: down, right, backward.
    }
    return np.stack(columns[convention], axis=2)


def _lenses(
    said: Matrix, size: tuple[int, int], path: Path, lens_of: LensOf
) -> tuple[list[Camera], list[str]]:
    """One a row (N, 3), and what is worth saying of them, once."""
    rows, places = np.unique(said, axis=0, return_inverse=True)
    each = [lens_of(row, size, path) for row in rows]
    lenses = [each[int(place)][0] for place in places.ravel()]
    notices = list(dict.fromkeys(told for _, notices in each for told in notices))
    ends = f"{min(lens.fx for lens in lenses):.4g}", f"{max(lens.fx for lens in lenses):.4g}"
    if ends[0] != ends[1]:
        notices.append(f"{POSES}: the focal length varies from {ends[0]} to {ends[1]} px between frames")
    return lenses, notices
