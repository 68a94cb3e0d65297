"""StereoMIS as Deform3DGS (Yang et al., MICCAI 2024) converts it: EndoNeRF's layout with other contents."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from renderer.camera import Camera
from renderer.clip import Clip, Frame
from renderer.evenly import evenly_floored
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.readers.data_sets.endonerf import open_endonerf
from renderer.readers.data_sets.endonerf_poses import POSES, Matrix
from renderer.readers.geometry.depth_maps import within
from renderer.readers.image_files.picture_files import read_npy
from renderer.readers.image_files.pictures import upright_size
from renderer.readers.masks.tool_masks import SAMPLES, Sample, marks_tissue
from renderer.readers.numbered_files import numbered

FARTHEST = 250.0
"""Depth in mm beyond which the conversion keeps none."""


def is_converted_stereomis(path: Path) -> bool:
    """Whether an EndoNeRF folder has a principal point where the layout has the size of the pictures.

    A size that is a whole fraction of the pictures' may also be meant as one: then the masks, which
    mark tissue here, decide.
    """
    said = _said(path)
    if said is None:
        return False
    width, height = upright_size(next(iter(numbered(path / "images").values())))
    cy, cx, _ = map(float, said[0])
    if not (1.5 < width / cx < 3 and 1.5 < height / cy < 3):
        return False
    may_be_size = cx.is_integer() and cy.is_integer() and abs(width * cy - height * cx) < 0.005 * width * cy
    return not may_be_size or marks_tissue(_samples(path, DEFAULTS))


def open_converted_stereomis(path: Path, options: ClipOptions = DEFAULTS) -> Clip:
    """Opens a folder in EndoNeRF's layout whose masks mark tissue and whose poses hold (cy, cx, focal).

    Masks that clearly mark tools are read as such. Depth, whole mm in 8 bits, is known in (0, FARTHEST].
    The rest is as `open_endonerf` says.

    Raises:
        ClipError: as `open_endonerf`.
    """
    polarity = options.mask_polarity
    if polarity == "auto":
        inverted = [replace(sample, marked=~sample.marked) for sample in _samples(path, options)]
        polarity = "tool" if marks_tissue(inverted) else "tissue"
    clip = open_endonerf(path, replace(options, mask_polarity=polarity), _centred_lens)

    def read_frame(index: int) -> Frame:
        frame = clip.read_frame(index)
        depth = None if frame.depth is None else within(frame.depth, 0, FARTHEST)
        return replace(frame, depth=depth)

    said = (
        f"{POSES} holds a principal point, as converted StereoMIS does: masks are assumed to mark {polarity}"
    )
    return replace(clip, format="stereomis", read_frame=read_frame, notices=(*clip.notices, said))


def _centred_lens(said: Matrix, size: tuple[int, int], path: Path) -> tuple[Camera, list[str]]:
    cy, cx, focal = (float(value) for value in said)
    return Camera(focal, focal, cx, cy, *size), []


def _said(path: Path) -> Matrix | None:
    """The last column (N, 3) of each pose, where all hold numbers above 0."""
    try:
        rows = np.asarray(read_npy(path / POSES)[:, :15], dtype=np.float64).reshape(-1, 3, 5)[:, :, 4]
    except (OSError, ValueError, EOFError, IndexError, TypeError):
        return None  # `open_endonerf` says what is wrong with the file.
    if not rows.size or not np.isfinite(rows).all() or rows.min() <= 0:
        return None
    return rows


def _samples(path: Path, options: ClipOptions) -> list[Sample]:
    """A few frames of the folder with what their masks mark."""
    clip = open_endonerf(path, replace(options, mask_polarity="tool", bottom_rows=0), _centred_lens)
    frames = [clip.read_frame(place) for place in evenly_floored(range(len(clip)), SAMPLES)]
    return [Sample(frame.image, ~frame.tissue_mask, frame.depth) for frame in frames]
