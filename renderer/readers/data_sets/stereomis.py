"""Sequences of StereoMIS (Hayoz et al., 2023) as their preprocessing leaves them."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from renderer.camera import FloatArray
from renderer.clip import BoolImage, ByteImage, Clip, ClipError
from renderer.listing import listed
from renderer.readers.clip_files import ClipFiles, numbered_pictures, those_there
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.readers.geometry.number_tables import read_table
from renderer.readers.geometry.poses import pose_matrix
from renderer.readers.image_files.file_kinds import is_picture
from renderer.readers.image_files.pictures import common_size, read_rgb
from renderer.readers.lenses.rectification import read_rectified
from renderer.readers.masks.mask_checks import judged_nonzero
from renderer.readers.masks.nonzero_masks import read_nonzero, require_shapes
from renderer.readers.masks.tool_masks import Sample
from renderer.readers.new_clip import Known, new_clip
from renderer.readers.numbered_files import numbered

CALIBRATION, TRAJECTORY = "StereoCalibration.ini", "groundtruth.txt"
METRE = 1000.0
"""In mm: positions of groundtruth.txt are in metres."""


def is_stereomis(path: Path) -> bool:
    """Whether the folder holds StereoCalibration.ini."""
    return (path / CALIBRATION).is_file()


def stereomis_files(path: Path) -> ClipFiles:
    """What a sequence is read from."""
    frames = filter(_is_left, numbered_pictures(_frame_folder(path)))
    masks = filter(_is_left, numbered_pictures(path / "masks"))
    return ClipFiles(tuple(frames), (*masks, *those_there(path, (CALIBRATION, TRAJECTORY))))


def open_stereomis(path: Path, options: ClipOptions = DEFAULTS) -> Clip:
    """Opens a sequence with StereoCalibration.ini and rectified pictures NNNNNNl.png, NNNNNNr.png.

    The pictures lie in video_frames/ or in the folder itself; the left ones are the frames. Their
    camera is that of the rectification, see `read_rectified`. groundtruth.txt has a line "number x y z
    qx qy qz qw" a frame, camera-to-world in metres and OpenCV axes; without it the camera stands still.
    In masks/NNNNNNl.png what is not zero is tissue; frames without a mask are left out, as Deform3DGS
    does. There is no measured depth.

    Raises:
        ClipError: parts that are missing or do not agree, masks that look inverted, a bad calibration.
    """
    images = _lefts(_frame_folder(path))
    masks = numbered(path / "masks", _is_left) if (path / "masks").is_dir() else {}
    kept = [number for number in images if number in masks or not masks]
    if not kept:
        raise ClipError(f"expected a mask numbered as an image, got none: {path / 'masks'}")
    size = common_size(images[number] for number in kept)
    require_shapes((masks[number] for number in kept if masks), size)
    rectified = read_rectified(path / CALIBRATION, size)
    poses = _poses(path / TRAJECTORY, kept) if (path / TRAJECTORY).is_file() else []
    cameras = tuple(rectified.camera.moved(pose) for pose in poses) or (rectified.camera,) * len(kept)
    ordered = tuple(images[number] for number in kept)
    reader = _Reader(
        ordered, tuple(masks[number] for number in kept if masks), size, options.mask_polarity != "tool"
    )
    said = judged_nonzero(reader.masks, "tissue", reader.sample, options)
    clip = new_clip(
        path,
        "stereomis",
        cameras=cameras,
        labels=tuple(entry.name for entry in ordered),
        read_image=reader.image,
        known=reader.known,
        unit="mm",
        notices=(*_notices(images, kept, bool(masks), bool(poses)), *said),
    )
    return replace(clip, baseline=rectified.baseline)


@dataclass(frozen=True, eq=False)
class _Reader:
    images: tuple[Path, ...]
    masks: tuple[Path, ...]
    size: tuple[int, int]
    marked_is_tissue: bool

    def image(self, index: int) -> ByteImage:
        return read_rgb(self.images[index])

    def marked(self, index: int) -> BoolImage:
        return read_nonzero(self.masks[index], self.size)

    def sample(self, index: int) -> Sample:
        return Sample(self.image(index), self.marked(index), None)

    def known(self, index: int) -> Known:
        return Known(np.equal(self.marked(index), self.marked_is_tissue) if self.masks else None)


def _frame_folder(path: Path) -> Path:
    return path / "video_frames" if (path / "video_frames").is_dir() else path


def _lefts(folder: Path) -> dict[int, Path]:
    if not any(_is_left(entry) for entry in folder.iterdir()):
        wanted = "images NNNNNNl.png, as the preprocessing extracts them from the video"
        raise ClipError(f"expected {wanted}, got none: {folder}")
    return numbered(folder, _is_left)


def _is_left(path: Path) -> bool:
    return is_picture(path) and re.fullmatch(r"\d+l", path.stem) is not None


def _poses(path: Path, numbers: list[int]) -> list[FloatArray]:
    """World-to-camera matrices in mm of the frames of these numbers."""
    rows = read_table(path)
    if rows.shape[1] != 8:
        raise ClipError(f"expected lines of number x y z qx qy qz qw, got {rows.shape[1]} numbers: {path}")
    found = {round(row[0]): row[1:] for row in rows}
    missing = [str(number) for number in numbers if number not in found]
    if missing:
        raise ClipError(f"expected a pose for every frame, got none for number {listed(missing)}: {path}")
    return [_camera_from_world(found[number], number, path) for number in numbers]


def _camera_from_world(row: FloatArray, number: int, path: Path) -> FloatArray:
    try:
        return np.linalg.inv(pose_matrix(METRE * row[:3], row[3:])).astype(np.float64)
    except ValueError as error:
        raise ClipError(f"frame {number}: {error}: {path}") from error


def _notices(images: dict[int, Path], kept: list[int], masks: bool, poses: bool) -> tuple[str, ...]:
    said = []
    if len(kept) < len(images):
        said.append(f"{len(images) - len(kept)} of {len(images)} frames have no mask and are left out")
    if not masks:
        said.append("no masks/: every pixel is treated as tissue")
    if not poses:
        said.append(f"no {TRAJECTORY}: the camera is assumed fixed")
    return tuple(said)
