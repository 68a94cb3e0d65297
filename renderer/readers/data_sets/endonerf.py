"""EndoNeRF folders: images, depth, masks, gt_masks and poses_bounds.npy (Wang et al., MICCAI 2022)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from renderer.clip import BoolImage, ByteImage, Clip, ClipError, Frame
from renderer.evenly import evenly_floored
from renderer.listing import listed
from renderer.readers.clip_files import ClipFiles, pictures_of, those_there
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.readers.data_sets.endonerf_poses import POSES, LensOf, cameras_of, load_poses, sized_lens
from renderer.readers.geometry.depth_maps import OUTLIER, DepthMap, read_map
from renderer.readers.image_files.pictures import common_size, read_rgb
from renderer.readers.masks.mask_checks import judged, labels_of, unmarked
from renderer.readers.masks.nonzero_masks import read_mask
from renderer.readers.masks.tool_masks import SAMPLES, Sample, burned_in_rows, marked_pixels
from renderer.readers.new_clip import Known, new_clip
from renderer.readers.numbered_files import numbered, strays

FOLDERS = ("images", "depth", "depth_fine", "masks", "gt_masks")
FINE_STEPS = 32
"""Steps per millimetre of the PNGs in depth_fine/."""

_DISAGREEING = 0.02
"""Share of the tissue."""


def is_endonerf(path: Path) -> bool:
    """Whether the folder holds images/ and a sign that it is more than a folder of pictures."""
    signs = (POSES, "depth", "masks")
    return (path / "images").is_dir() and any((path / sign).exists() for sign in signs)


def endonerf_files(path: Path) -> ClipFiles:
    """What a folder of this layout is read from; depth/ too where depth_fine/ is preferred."""
    frames, *others = FOLDERS
    return ClipFiles(pictures_of(path, [frames]), (*pictures_of(path, others), *those_there(path, [POSES])))


def open_endonerf(path: Path, options: ClipOptions = DEFAULTS, lens_of: LensOf = sized_lens) -> Clip:
    """Opens a folder in EndoNeRF layout; frames are decoded when they are asked for.

    Files are paired by the last number in their names. depth/ holds millimetres along z in 8-bit,
    16-bit or float pictures, 0 = none, and so is depth far from the frame's median (OUTLIER);
    depth_fine/ (1/32 mm, 16 bit), which `write_endonerf` adds, is preferred. Without masks every
    pixel is tissue; without depth the clip has none.

    `Frame.tissue_mask` is the complement of gt_masks (tools alone), or of masks where there are none,
    without burned-in rows; depth counts within masks alone, which leave out failed stereo matches too.
    `Frame.evaluation_mask` follows `options.evaluation_masks` and keeps the rows as the files have them,
    so that figures stay comparable with published ones.

    Raises:
        ClipError: parts that are missing or do not agree, masks that look inverted, bad poses.
    """
    rows = load_poses(path / POSES)
    files, notices = _pair(path, options)
    size = common_size((*files.images, *files.depth, *files.masks, *files.tools))
    if len(rows) != len(files.images):
        counts = f"images/ has {len(files.images)} files but {POSES} has {len(rows)} frames"
        raise ClipError(f"{counts}: {path}")
    cameras, pose_notices = cameras_of(rows, size, options.pose_convention, path / POSES, lens_of)
    reader, mask_notices = _reader(path, files, size, options)
    return new_clip(
        path,
        "endonerf",
        cameras=cameras,
        labels=tuple(entry.name for entry in files.images),
        read_image=reader.image,
        known=reader.known,
        has_depth=bool(files.depth),
        unit="mm" if files.depth else "scene units",
        notices=(*notices, *pose_notices, *mask_notices),
    )


@dataclass(frozen=True)
class _Files:
    """One path a frame, in the order of frame numbers; empty where the clip has none."""

    images: tuple[Path, ...]
    depth: tuple[Path, ...]
    depth_steps: int
    """Per millimetre."""
    masks: tuple[Path, ...]
    """Tools, and pixels without stereo depth."""
    tools: tuple[Path, ...]
    """Tools alone; as `masks` where the clip has no gt_masks."""


@dataclass(frozen=True)
class _Masks:
    """Masks of one kind, one a frame, or none."""

    paths: tuple[Path, ...]
    labels: int
    """Up to which value they are labels, see `labels_of`."""
    marked_is_tissue: bool
    size: tuple[int, int]
    """Width and height of the images."""

    @classmethod
    def of(
        cls, paths: tuple[Path, ...], looked_at: Sequence[int], options: ClipOptions, size: tuple[int, int]
    ) -> _Masks:
        labels = labels_of(paths, looked_at) if paths else 1
        return cls(paths, labels, options.mask_polarity == "tissue", size)

    def marked(self, index: int) -> BoolImage:
        """(H, W), by the file; without one nothing, or everything where what is marked is tissue."""
        if not self.paths:
            return np.full(self.size[::-1], self.marked_is_tissue)
        return marked_pixels(read_mask(self.paths[index]), self.labels)

    def tissue(self, index: int) -> BoolImage:
        return np.equal(self.marked(index), self.marked_is_tissue)


def _reader(
    path: Path, files: _Files, size: tuple[int, int], options: ClipOptions
) -> tuple[_Reader, list[str]]:
    """What reads frames, and what is worth saying of their masks. Raises ClipError: see `open_endonerf`."""
    looked_at = evenly_floored(range(len(files.images)), SAMPLES)
    masks = _Masks.of(files.masks, looked_at, options, size)
    tools = masks if files.tools == files.masks else _Masks.of(files.tools, looked_at, options, size)
    reader = _Reader(files, masks, tools, options.evaluation_masks)
    samples = [reader.sample(index) for index in looked_at]
    notices = []
    if masks.paths:
        notices = judged(masks.paths[0].parent, samples, options)
        notices += unmarked([masks.paths[index] for index in looked_at], masks.labels)
    if not all(reader.tools_agree(index) for index in looked_at):
        reader = replace(reader, tools=masks)
        notices.append("gt_masks/ marks tissue of masks/ as tool, and is not trained on")
    dead = burned_in_rows(samples) if options.bottom_rows is None else options.bottom_rows
    if dead >= size[1]:
        raise ClipError(f"expected bottom_rows below {size[1]}, the rows of the images, got {dead}: {path}")
    if dead:
        notices.append(f"the last {dead} rows are burned-in text and not trained on")
    return replace(reader, bottom_rows=dead), notices


@dataclass(frozen=True, eq=False)
class _Reader:
    files: _Files
    masks: _Masks
    tools: _Masks
    """`masks` itself where the clip has no others, or none that agree."""
    evaluation: Literal["masks", "gt_masks"]
    bottom_rows: int = 0

    def image(self, index: int) -> ByteImage:
        return read_rgb(self.files.images[index])

    def depth(self, index: int) -> DepthMap | None:
        if not self.files.depth:
            return None
        return _plausible(read_map(self.files.depth[index]) / np.float32(self.files.depth_steps))

    def sample(self, index: int) -> Sample:
        return Sample(self.image(index), self.masks.marked(index), self.depth(index))

    def tools_agree(self, index: int) -> bool:
        """Whether nearly all tissue of masks is tissue of gt_masks, which leave out less."""
        tissue = self.masks.tissue(index)
        lost = tissue & ~self.tools.tissue(index)
        return bool(np.count_nonzero(lost) <= _DISAGREEING * np.count_nonzero(tissue))

    def known(self, index: int) -> Known:
        reliable = self.masks.tissue(index)
        tools = reliable if self.tools is self.masks else self.tools.tissue(index)
        depth, tissue = self.depth(index), tools.copy()
        tissue[len(tissue) - self.bottom_rows :] = False
        evaluation = reliable if self.evaluation == "masks" else tools
        return Known(tissue, evaluation, None if depth is None else np.where(reliable, depth, np.float32(0)))


def _plausible(depth: DepthMap) -> DepthMap:
    """As `plausible` of other layouts, but without its ends, on which whole millimetres often lie: training
    takes what these leave, to the pixel."""
    measured = depth[depth > 0]
    if not measured.size:
        return depth
    median = np.median(measured)
    return np.where((depth < OUTLIER * median) & (depth * OUTLIER > median), depth, np.float32(0))


def _pair(path: Path, options: ClipOptions) -> tuple[_Files, list[str]]:
    """The files of every frame in the order of frame numbers, and what is worth saying about them."""
    images = numbered(path / "images")
    fine = _paired(path, "depth_fine", images)
    depth = fine or _paired(path, "depth", images)
    tools = _paired(path, "gt_masks", images)
    masks = _paired(path, "masks", images) or tools
    if options.evaluation_masks == "gt_masks" and not tools:
        raise ClipError(f"expected gt_masks/ for the evaluation, got no such folder: {path}")
    there = (path / name for name in FOLDERS if (path / name).is_dir())
    notices = [stray for folder in there for stray in strays(images, folder)]
    if not depth:
        notices.append("no depth/: no measured depth")
    if not masks:
        notices.append("no masks/: every pixel is treated as tissue")
    return _Files(tuple(images.values()), depth, FINE_STEPS if fine else 1, masks, tools or masks), notices


def _paired(path: Path, name: str, images: dict[int, Path]) -> tuple[Path, ...]:
    """The files of a folder that belong to the images, in their order; none when it is not there."""
    if not (path / name).is_dir():
        return ()
    found = numbered(path / name)
    _agree(path, "images", images, name, found)
    _agree(path, name, found, "images", images)
    return tuple(found[number] for number in images)


def _agree(path: Path, name: str, found: dict[int, Path], other: str, others: dict[int, Path]) -> None:
    missing = [str(number) for number in sorted(found.keys() - others.keys())]
    if missing:
        counts = f"{name}/ has {len(found)} frames but {other}/ has {len(others)}"
        raise ClipError(f"{counts}: {other}/ lacks number {listed(missing)}: {path}")


def write_endonerf(folder: Path, frames: Iterable[Frame]) -> None:
    """Writes frames that have depth in EndoNeRF layout into `folder`, creating it.

    masks/ is the complement of tissue_mask, gt_masks/ of evaluation_mask; depth/ holds whole
    millimetres as in the wild, depth_fine/ the same in 1/32 mm (error at most 1/64 mm, up to
    2047 mm). Poses are OpenCV camera-to-world.

    Raises:
        ClipError: a frame without depth.
        OSError: the folder cannot be written.
    """
    rows = []
    for frame in frames:
        if frame.depth is None:
            raise ClipError(f"expected depth in every frame, frame {frame.index} has none: {folder}")
        pictures: dict[str, NDArray[Any]] = {
            "images/{}.color.png": frame.image,
            "depth/{}.depth.png": np.rint(frame.depth).astype(np.uint16),
            "depth_fine/{}.depth.png": np.rint(frame.depth * FINE_STEPS).astype(np.uint16),
            "masks/{}.mask.png": np.where(frame.tissue_mask, 0, 255).astype(np.uint8),
            "gt_masks/{}.mask.png": np.where(frame.evaluation_mask, 0, 255).astype(np.uint8),
        }
        for pattern, picture in pictures.items():
            path = folder / pattern.format(f"frame-{frame.index:06d}")
            path.parent.mkdir(parents=True, exist_ok=True)
            Image.fromarray(picture).save(path, compress_level=9)
        camera, measured = frame.camera, frame.depth[frame.depth > 0]
        lens = np.array([camera.height, camera.width, camera.fx])
        pose = np.column_stack([camera.world_from_camera[:3], lens])
        bounds = (measured.min(), measured.max()) if measured.size else (0.0, 0.0)
        rows.append(np.append(pose.ravel(), bounds))
    np.save(folder / POSES, np.array(rows, dtype=np.float64))
