"""Clips of the Hamlyn set in the layout of ForPlane (Yang et al., 2023)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.clip import BoolImage, ByteImage, Clip, ClipError
from renderer.readers.clip_files import ClipFiles, pictures_of, those_there
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.readers.data_sets.endonerf_poses import POSES
from renderer.readers.geometry.depth_maps import DepthMap, plausible, read_map
from renderer.readers.geometry.number_tables import read_table
from renderer.readers.image_files.pictures import common_size, read_rgb
from renderer.readers.masks.mask_checks import judged_nonzero
from renderer.readers.masks.nonzero_masks import read_nonzero
from renderer.readers.masks.tool_masks import Sample
from renderer.readers.new_clip import Known, new_clip
from renderer.readers.numbered_files import beside, numbered, strays

LEFT_COLUMNS = 40
"""Columns at the left without stereo depth: cut off, as the field does."""

INTRINSICS = "intrinsics.txt"

_MASKS, _DEPTH, _RIGHT = "gt_masks", ("gt_depth", "depth"), "images_right"


def is_hamlyn(path: Path) -> bool:
    """Whether the folder holds images/ and intrinsics.txt, but no poses."""
    has_poses = (path / POSES).exists()
    return (path / "images").is_dir() and (path / INTRINSICS).is_file() and not has_poses


def hamlyn_files(path: Path) -> ClipFiles:
    """What a folder of this layout is read from; depth/ too where gt_depth/ is preferred."""
    maps = pictures_of(path, (_MASKS, *_DEPTH))
    return ClipFiles(pictures_of(path, ["images"]), (*maps, *those_there(path, [INTRINSICS])))


def open_hamlyn(path: Path, options: ClipOptions = DEFAULTS) -> Clip:
    """Opens a folder with images/, intrinsics.txt, gt_masks/ and gt_depth/ or depth/.

    The camera is that of intrinsics.txt (3, 3), whose principal point counts from the centre of the
    first pixel, for the whole pictures; LEFT_COLUMNS are cut off pictures, masks and depth alike and
    the principal point moves by as many. It stands still. What is not zero in gt_masks/ is a tool;
    depth is in mm along z, 0 and what is far from the frame's median is no measurement. Nothing is
    resampled. The field trains on even frames and tests on odd ones: `options.split` "even-odd". Pictures of
    the right eye in images_right/ are cut alike, which leaves disparities as they are.

    Raises:
        ClipError: parts that are missing or do not agree, masks that look inverted, bad intrinsics.
    """
    images = numbered(path / "images")
    masks = beside(images, path / _MASKS) if (path / _MASKS).is_dir() else ()
    folder = next((name for name in _DEPTH if (path / name).is_dir()), None)
    depth = beside(images, path / folder) if folder else ()
    right = beside(images, path / _RIGHT) if (path / _RIGHT).is_dir() else ()
    width, height = common_size((*images.values(), *masks, *depth, *right))
    if width <= LEFT_COLUMNS:
        raise ClipError(f"expected images wider than {LEFT_COLUMNS} px, got {width}x{height}: {path}")
    camera = _camera(path / INTRINSICS, width, height)
    reader = _Reader(tuple(images.values()), masks, depth, camera, options.mask_polarity == "tissue")
    parts = ["images", *([_MASKS] if masks else []), *([folder] if folder else [])]
    said = [stray for part in parts for stray in strays(images, path / part)]
    if not depth:
        said.append("no gt_depth/ and no depth/: no measured depth")
    said += judged_nonzero(masks, "tool", reader.sample, options)
    if not masks:
        said.append("no gt_masks/: every pixel is treated as tissue")
    clip = new_clip(
        path,
        "hamlyn",
        cameras=(camera,) * len(images),
        labels=tuple(entry.name for entry in images.values()),
        read_image=reader.image,
        known=reader.known,
        has_depth=bool(depth),
        unit="mm" if depth else "scene units",
        notices=tuple(said),
    )
    return replace(clip, read_right=lambda index: _cut(read_rgb(right[index]))) if right else clip


def _cut(image: ByteImage) -> ByteImage:
    return np.ascontiguousarray(image[:, LEFT_COLUMNS:])


@dataclass(frozen=True, eq=False)
class _Reader:
    images: tuple[Path, ...]
    masks: tuple[Path, ...]
    depth_files: tuple[Path, ...]
    camera: Camera
    marked_is_tissue: bool

    def image(self, index: int) -> ByteImage:
        return _cut(read_rgb(self.images[index]))

    def depth(self, index: int) -> DepthMap | None:
        if not self.depth_files:
            return None
        return plausible(read_map(self.depth_files[index])[:, LEFT_COLUMNS:])

    def marked(self, index: int) -> BoolImage:
        size = self.camera.width + LEFT_COLUMNS, self.camera.height
        return read_nonzero(self.masks[index], size)[:, LEFT_COLUMNS:]

    def sample(self, index: int) -> Sample:
        return Sample(self.image(index), self.marked(index), self.depth(index))

    def known(self, index: int) -> Known:
        tissue = np.equal(self.marked(index), self.marked_is_tissue) if self.masks else None
        return Known(tissue, depth=self.depth(index))


def _camera(path: Path, width: int, height: int) -> Camera:
    """The camera of pictures whose left columns are cut off."""
    k = _intrinsics(path)
    # OpenCV counts from the centre of the first pixel, which here is at 0.5.
    cx, cy = k[0, 2] + 0.5 - LEFT_COLUMNS, k[1, 2] + 0.5
    return Camera(float(k[0, 0]), float(k[1, 1]), float(cx), float(cy), width - LEFT_COLUMNS, height)


def _intrinsics(path: Path) -> FloatArray:
    matrix = read_table(path)
    if matrix.shape != (3, 3):
        raise ClipError(f"expected a 3x3 matrix, got shape {matrix.shape}: {path}")
    if min(matrix[0, 0], matrix[1, 1]) <= 0 or np.abs(matrix[2] - (0, 0, 1)).max() > 1e-9:
        raise ClipError(f"expected intrinsics fx 0 cx, 0 fy cy, 0 0 1, got {matrix.tolist()}: {path}")
    return matrix
