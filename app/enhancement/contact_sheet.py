"""The images of a tuning grid beside each other, with what each was made with and what it measures."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

from app.enhancement.parameter_grid import Cell, Measures
from app.files.image_files import ArrayImage
from app.files.provenance import NOTICE
from app.files.sheet import Tile, sheet
from renderer.clip import ByteImage

TILE_WIDTH = 320
FOOT = f"DV/BV: inferred definition. Visibility only, neither detection nor diagnosis. {NOTICE}"


def tile(cell: Cell) -> Tile:
    """As wide as the sheet has room for; the label leaves out what differs from one time to the next."""
    return Tile(f"{cell.setting.label}   {in_words(cell.measures)}", small(cell.image, TILE_WIDTH))


def in_words(measures: Measures) -> str:
    """The three that tell most, in words."""
    contrast, noise = measures.vessel_contrast, measures.noise_gain
    return f"DV/BV {measures.dv_bv:.3g} · contrast {contrast:.3g} · noise gain {noise:.2g}"


def small(image: ArrayImage, width: int) -> ByteImage:
    """(H, width, 3) uint8 of a picture of any type."""
    full = np.iinfo(image.dtype).max if image.dtype.kind == "u" else 1.0
    colors = np.repeat(image[..., None], 3, axis=2) if image.ndim == 2 else image[..., :3]
    height = max(1, round(colors.shape[0] * width / colors.shape[1]))
    way = cv2.INTER_AREA if colors.shape[1] > width else cv2.INTER_LINEAR
    scaled = cv2.resize(colors.astype(np.float32) * (255 / full), (width, height), interpolation=way)
    return np.rint(np.clip(scaled, 0, 255)).astype(np.uint8)


def contact_sheet(title: str, tiles: Sequence[Tile], columns: int) -> ByteImage:
    """(H, W, 3) RGB."""
    return sheet(title, tiles, FOOT, columns=columns, tile_width=TILE_WIDTH)


def columns_of(axis_lengths: Sequence[int], *, in_order: bool) -> int:
    """Two axes are rows and columns as long as they are in order; else about as many of each."""
    count = math.prod(axis_lengths)
    as_grid = in_order and len(axis_lengths) == 2 and axis_lengths[1] <= 12
    return axis_lengths[1] if as_grid else max(1, math.ceil(math.sqrt(count)))
