"""The scale of an image's colours, drawn beside it."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from app.scenes.view_kinds import Composed, Scale
from renderer.clip import ByteImage

INK, GROUND = (235, 235, 235), (28, 28, 28)
LEAST_HEIGHT = 96
"""Pixels; beside a lower picture there is no room for numbers."""


def with_bar(composed: Composed) -> ByteImage:
    """(H, W', 3): the picture with its scale to the right, where it has one; at least 96 pixels high."""
    if composed.scale is None:
        return composed.image
    height = max(composed.image.shape[0], LEAST_HEIGHT)
    bar = color_bar(composed.scale, height)
    page = np.zeros((height, composed.image.shape[1] + bar.shape[1], 3), np.uint8)
    page[: composed.image.shape[0], : composed.image.shape[1]] = composed.image
    page[:, composed.image.shape[1] :] = bar
    return page


def color_bar(scale: Scale, height: int) -> ByteImage:
    """(height, W, 3): high values above, ticks with their numbers, the unit on top."""
    size = min(max(11, height // 28), 22)
    font = ImageFont.load_default(size)
    texts = [scale.text(tick) for tick in scale.ticks]
    margin, across = size // 2, size
    width = int(
        max(*(font.getlength(text) + 2.5 * size for text in texts), font.getlength(scale.unit) + size)
    )
    page = Image.new("RGB", (width, height), GROUND)
    draw = ImageDraw.Draw(page)
    draw.text((margin, margin + size // 2), scale.unit, INK, font, anchor="lm")
    top, bottom = 2 * size + margin, height - size
    column = scale.table[np.linspace(255, 0, bottom - top).astype(int)]
    page.paste(Image.fromarray(np.repeat(column[:, None], across, axis=1)), (margin, top))
    for tick, text in zip(scale.ticks, texts, strict=True):
        y = bottom - (tick - scale.low) / (scale.high - scale.low) * (bottom - top)
        draw.line((margin + across, y, margin + across + size // 3, y), INK)
        draw.text((margin + across + size // 2, y), text, INK, font, anchor="lm")
    return np.asarray(page, dtype=np.uint8)
