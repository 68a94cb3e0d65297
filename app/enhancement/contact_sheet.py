"""Sheets of labelled images: a comparison side by side, a strip through time, the images of a tuning grid."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import cv2
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from app.enhancement.measures import Measures
from app.enhancement.parameter_grid import Cell
from app.files.image_files import ArrayImage
from app.files.provenance import NOTICE
from enhance.image import full_scale
from renderer.clip import ByteImage

TILE_WIDTH = 320
FOOT = f"DV/BV: inferred definition. Visibility only, neither detection nor diagnosis. {NOTICE}"
# A neutral grey: a tint beside a picture changes how its colours are seen.
BACKGROUND = (40, 40, 40)
TEXT = (232, 232, 232)
FAINT = (160, 160, 160)
GAP = 12
LABEL_SIZE, LINE_HEIGHT, LABEL_PADDING = 16, 20, 10
TITLE_HEIGHT = 40
FOOT_HEIGHT = 28
Undefined = Literal["none", "nan"]
"""What a sheet says of a measure that cannot be taken; "nan" as before 0.4.0."""


@dataclass(frozen=True, eq=False)
class Tile:
    """One picture (H, W, 3) RGB with the words above it."""

    label: str
    """In as many lines as it needs, where it has no breaks of its own."""
    image: ByteImage


def sheet(
    title: str, tiles: Sequence[Tile], foot: str, *, columns: int, tile_width: int, breaks: bool = True
) -> ByteImage:
    """The tiles in rows of `columns`, each scaled to `tile_width` pixels, as an (H, W, 3) RGB picture.

    Raises:
        ValueError: no tile.
    """
    if not tiles:
        raise ValueError("expected at least one tile, got none")
    images = [_scaled(tile.image, tile_width) for tile in tiles]
    labels = [
        _lines(tile.label, tile_width) if breaks else [tile.label.replace("\n", "   ")] for tile in tiles
    ]
    rows, above = -(-len(tiles) // columns), LINE_HEIGHT * max(map(len, labels)) + LABEL_PADDING
    cell = max(image.shape[0] for image in images) + above
    width = GAP + min(columns, len(tiles)) * (tile_width + GAP)
    canvas = Image.new("RGB", (width, TITLE_HEIGHT + rows * (cell + GAP) + FOOT_HEIGHT), BACKGROUND)
    draw = ImageDraw.Draw(canvas)
    _write(draw, (GAP, 0), TITLE_HEIGHT, title, 20, TEXT, width - 2 * GAP)
    for index, (lines, image) in enumerate(zip(labels, images, strict=True)):
        x = GAP + index % columns * (tile_width + GAP)
        y = TITLE_HEIGHT + index // columns * (cell + GAP)
        top = y + LABEL_PADDING // 2
        for place, line in enumerate(lines):
            _write(draw, (x, top + place * LINE_HEIGHT), LINE_HEIGHT, line, LABEL_SIZE, TEXT, tile_width)
        canvas.paste(Image.fromarray(image), (x, y + above))
    _write(draw, (GAP, canvas.height - FOOT_HEIGHT), FOOT_HEIGHT, foot, 14, FAINT, width - 2 * GAP)
    return np.array(canvas)


def _lines(text: str, room: int) -> list[str]:
    """Broken between words, so that letters keep their size; a word that is too wide stands alone."""
    font: Any = ImageFont.load_default(LABEL_SIZE)
    lines: list[str] = []
    for part in text.split("\n"):
        line = ""
        for word in part.split():
            longer = f"{line} {word}".strip()
            if line and font.getlength(longer) > room:
                lines.append(line)
                longer = word
            line = longer
        lines.append(line)
    return lines


def _scaled(image: ByteImage, width: int) -> ByteImage:
    height = max(1, round(image.shape[0] * width / image.shape[1]))
    way = cv2.INTER_AREA if width < image.shape[1] else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(image, (width, height), interpolation=way), dtype=np.uint8)


def _write(
    draw: ImageDraw.ImageDraw,
    corner: tuple[int, int],
    height: int,
    text: str,
    size: int,
    color: tuple[int, int, int],
    room: int,
) -> None:
    """One line, vertically centred in `height`, made smaller until it fits into `room` pixels."""
    text = text.replace("\n", " ")  # As of a file's name.
    font: Any = ImageFont.load_default(size)
    while size > 8 and draw.textlength(text, font=font) > room:
        size -= 1
        font = ImageFont.load_default(size)
    draw.text((corner[0], corner[1] + height / 2), text, fill=color, font=font, anchor="lm")


def tile(cell: Cell, label: str, undefined: Undefined = "none") -> Tile:
    """As wide as the sheet has room for; of the measures without what differs from one time to the next."""
    return Tile(f"{label}\n{in_words(cell.measures, undefined)}", small(cell.image, TILE_WIDTH))


def in_words(measures: Measures, undefined: Undefined = "none") -> str:
    """The three that tell most, in words."""
    three = (measures.dv_bv, ".3g"), (measures.vessel_contrast, ".3g"), (measures.noise_gain, ".2g")
    ratio, contrast, noise = (undefined if math.isnan(one) else format(one, form) for one, form in three)
    return f"DV/BV {ratio} · contrast {contrast} · noise gain {noise}"


def small(image: ArrayImage, width: int) -> ByteImage:
    """(H, width, 3) uint8 of a picture of any type."""
    colors = np.repeat(image[..., None], 3, axis=2) if image.ndim == 2 else image[..., :3]
    height = max(1, round(colors.shape[0] * width / colors.shape[1]))
    way = cv2.INTER_AREA if colors.shape[1] > width else cv2.INTER_LINEAR
    levels = np.multiply(colors, 255 / full_scale(image.dtype), dtype=np.float32)
    scaled = cv2.resize(levels, (width, height), interpolation=way)
    return np.asarray(np.rint(np.clip(scaled, 0, 255)), np.uint8)


def contact_sheet(title: str, tiles: Sequence[Tile], columns: int, *, breaks: bool) -> ByteImage:
    """(H, W, 3) RGB; a label has lines, or is one that is made smaller until it fits."""
    return sheet(title, tiles, FOOT, columns=columns, tile_width=TILE_WIDTH, breaks=breaks)


def columns_of(axis_lengths: Sequence[int], *, in_order: bool) -> int:
    """Two axes are rows and columns as long as they are in order; else about as many of each."""
    count = math.prod(axis_lengths)
    as_grid = in_order and len(axis_lengths) == 2 and axis_lengths[1] <= 12
    return axis_lengths[1] if as_grid else max(1, math.ceil(math.sqrt(count)))
