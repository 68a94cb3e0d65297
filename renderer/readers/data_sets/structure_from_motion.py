"""Folders of structure from motion as Liu et al. (CVPR 2020) publish them: pictures, poses, sparse points."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.clip import BoolImage, Clip, ClipError
from renderer.evenly import evenly
from renderer.listing import listed
from renderer.readers.clip_files import ClipFiles, files_in, numbered_pictures, those_there
from renderer.readers.geometry.number_tables import read_table
from renderer.readers.geometry.point_ply import read_points
from renderer.readers.geometry.poses import pose_matrix
from renderer.readers.image_files.file_kinds import is_picture
from renderer.readers.image_files.pictures import common_size, read_rgb, read_stored
from renderer.readers.masks.lit_part import is_displaced, lit_field
from renderer.readers.masks.tool_masks import marked_pixels
from renderer.readers.new_clip import Known, new_clip
from renderer.readers.numbered_files import numbered
from renderer.regular_files import read_whole

POSES, INTRINSICS, VIEWS = "motion.yaml", "camera_intrinsics_per_view", "visible_view_indexes"
POINTS, MASK = "structure.ply", "undistorted_mask"
SCALE = "the scale is that of structure from motion, not millimetres"
LOOKED_AT = 6
"""Pictures that the mask is checked against."""

_NUMBER = r"\s*([-+.\deE]+)\s*"
_POSE = re.compile(
    r"poses\[(\d+)\]:\s*position:\s*" + "".join(f"{axis}:{_NUMBER}" for axis in "xyz")
    + r"orientation:\s*" + "".join(f"{axis}:{_NUMBER}" for axis in "xyzw")
)  # fmt: skip


def is_structure_from_motion(path: Path) -> bool:
    """Whether the folder holds motion.yaml and camera_intrinsics_per_view."""
    return (path / POSES).is_file() and (path / INTRINSICS).is_file()


def structure_from_motion_files(path: Path) -> ClipFiles:
    """What such a folder is read from."""
    told = those_there(path, (POSES, INTRINSICS, VIEWS, POINTS))
    return ClipFiles(numbered_pictures(path), (*_masks(path), *told))


def open_structure_from_motion(path: Path) -> Clip:
    """Opens a folder of undistorted pictures with their poses; `Clip.points` holds structure.ply.

    motion.yaml has the camera-to-world pose (position, quaternion xyzw, OpenCV axes) of each view
    that was registered, in the order of the picture numbers in visible_view_indexes; pictures that
    were not registered are left out. camera_intrinsics_per_view has fx, fy, cx, cy, or f, cx, cy, for all
    views or for each, the principal point from the centre of the first pixel. undistorted_mask is set where
    the endoscope sees; one that lies beside the light of the pictures gives way to it. The scale is
    arbitrary and there is no dense depth.

    Raises:
        ClipError: parts that are missing or do not agree.
    """
    numbers = _views(path / VIEWS)
    poses = _poses(path / POSES, len(numbers))
    pictures = numbered(path)
    images = _pictures_of(pictures, numbers, path)
    mask_file = next(iter(_masks(path)), None)
    width, height = common_size((*images, *((mask_file,) if mask_file else ())))
    cameras = tuple(
        Camera(fx, fy, cx + 0.5, cy + 0.5, width, height, np.linalg.inv(pose).astype(np.float64))
        for (fx, fy, cx, cy), pose in zip(_intrinsics(path / INTRINSICS, len(numbers)), poses, strict=True)
    )
    seen, said = _seen(mask_file, images, (height, width))
    clip = new_clip(
        path,
        "structure-from-motion",
        cameras=cameras,
        labels=tuple(entry.name for entry in images),
        read_image=lambda index: read_rgb(images[index]),
        known=lambda index: Known(seen),
        notices=(*_loose(pictures, numbers), *said, SCALE),
    )
    return replace(clip, points=read_points(path / POINTS))


def _masks(path: Path) -> list[Path]:
    """The first of which is read."""
    return sorted(entry for entry in files_in(path) if entry.match(f"{MASK}.*") and is_picture(entry))


def _pictures_of(pictures: dict[int, Path], numbers: list[int], path: Path) -> tuple[Path, ...]:
    missing = [str(number) for number in numbers if number not in pictures]
    if missing:
        raise ClipError(f"expected an image of every view in {VIEWS}, got none of {listed(missing)}: {path}")
    return tuple(pictures[number] for number in numbers)


def _seen(
    mask_file: Path | None, images: tuple[Path, ...], shape: tuple[int, int]
) -> tuple[BoolImage, tuple[str, ...]]:
    """(H, W), where the endoscope sees, and what is to be said of it."""
    if mask_file is None:
        return np.ones(shape, dtype=bool), (f"no {MASK}: every pixel is treated as tissue",)
    mask = marked_pixels(read_stored(mask_file))
    field = lit_field([read_rgb(image) for image in evenly(images, LOOKED_AT)])
    if not is_displaced(mask, field):
        return mask, ()
    beyond = f"{100 * np.mean(~mask[field]):.0f} % of what the images show is outside it"
    return field, (f"{mask_file.name} does not match the images, {beyond}: their lit part is used instead",)


def _loose(pictures: dict[int, Path], numbers: list[int]) -> tuple[str, ...]:
    known = set(numbers)
    loose = [entry.name for number, entry in pictures.items() if number not in known]
    return (f"left out, views without a pose: {listed(loose)}",) if loose else ()


def _poses(path: Path, count: int) -> list[FloatArray]:
    """Camera-to-world matrices (4, 4) in the order of their numbers."""
    found = {int(pose[0]): pose[1:] for pose in _POSE.findall(read_whole(path).decode(errors="replace"))}
    if sorted(found) != list(range(count)):
        raise ClipError(f"expected poses 0 to {count - 1}, as many as views, got {len(found)}: {path}")
    return [_pose(found[number], number, path) for number in range(count)]


def _pose(words: tuple[str, ...], number: int, path: Path) -> FloatArray:
    try:
        values = np.array(words, dtype=np.float64)
        return pose_matrix(values[:3], values[3:])
    except ValueError as error:
        raise ClipError(f"pose {number}: {error}: {path}") from error


def _intrinsics(path: Path, count: int) -> list[tuple[float, ...]]:
    """fx, fy, cx, cy of each view; three numbers are f, cx, cy."""
    values = read_table(path)
    width = next((each for each in (4, 3) if values.size in (each, each * count)), None)
    if width is None or (values.shape[1] > 1 and values.shape[1] != width and values.shape[0] > 1):
        wanted = f"fx, fy, cx, cy or f, cx, cy once or for {count} views"
        raise ClipError(f"expected {wanted}, got {values.size} numbers: {path}")
    rows = [tuple(map(float, row if width == 4 else row[[0, 0, 1, 2]])) for row in values.reshape(-1, width)]
    if min(min(row[:2]) for row in rows) <= 0:
        raise ClipError(f"expected focal lengths above 0, got {min(min(row[:2]) for row in rows):g}: {path}")
    return rows if len(rows) == count else rows * count


def _views(path: Path) -> list[int]:
    """Numbers of the pictures whose views were registered."""
    numbers = read_table(path).ravel()
    views = [int(number) for number in numbers]
    if (numbers != views).any() or min(views) < 0 or len(set(views)) < len(views):
        raise ClipError(f"expected the numbers of the views, whole and each once, got others: {path}")
    return views
