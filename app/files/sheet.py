"""Sheets of labelled images: the comparison side by side, and a strip through time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

ByteImage = NDArray[np.uint8]

# A neutral grey: a tint beside a picture changes how its colours are seen.
BACKGROUND = (40, 40, 40)
TEXT = (232, 232, 232)
FAINT = (160, 160, 160)
GAP = 12
LABEL_HEIGHT = 30
TITLE_HEIGHT = 40
FOOT_HEIGHT = 28


@dataclass(frozen=True, eq=False)
class Tile:
    """One picture (H, W, 3) RGB with the words above it."""

    label: str
    image: ByteImage


def sheet(title: str, tiles: Sequence[Tile], foot: str, *, columns: int, tile_width: int) -> ByteImage:
    """The tiles in rows of `columns`, each scaled to `tile_width` pixels, as an (H, W, 3) RGB picture.

    Raises:
        ValueError: no tile.
    """
    if not tiles:
        raise ValueError("expected at least one tile, got none")
    images = [_scaled(tile.image, tile_width) for tile in tiles]
    rows = -(-len(tiles) // columns)
    cell = max(image.shape[0] for image in images) + LABEL_HEIGHT
    width = GAP + min(columns, len(tiles)) * (tile_width + GAP)
    canvas = Image.new("RGB", (width, TITLE_HEIGHT + rows * (cell + GAP) + FOOT_HEIGHT), BACKGROUND)
    draw = ImageDraw.Draw(canvas)
    _write(draw, (GAP, 0), TITLE_HEIGHT, title, 20, TEXT, width - 2 * GAP)
    for index, (tile, image) in enumerate(zip(tiles, images, strict=True)):
        x = GAP + index % columns * (tile_width + GAP)
        y = TITLE_HEIGHT + index // columns * (cell + GAP)
        _write(draw, (x, y), LABEL_HEIGHT, tile.label, 16, TEXT, tile_width)
        canvas.paste(Image.fromarray(image), (x, y + LABEL_HEIGHT))
    _write(draw, (GAP, canvas.height - FOOT_HEIGHT), FOOT_HEIGHT, foot, 14, FAINT, width - 2 * GAP)
    return np.array(canvas)


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
    font: Any = ImageFont.load_default(size)
    while size > 8 and draw.textlength(text, font=font) > room:
        size -= 1
        font = ImageFont.load_default(size)
    draw.text((corner[0], corner[1] + height / 2), text, fill=color, font=font, anchor="lm")
