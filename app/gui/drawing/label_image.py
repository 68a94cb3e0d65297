"""Labels as an image, for a window that ImGui does not draw."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from imgui_bundle import ImVec4
from PIL import Image, ImageDraw, ImageFont

from app.files.legible import legible
from app.gui.state.tags import Tag
from app.gui.style import theme
from renderer.clip import ByteImage

LEAST, MOST = 13, 28
"""Pixels of a line of text."""


def label_image(labels: Sequence[Tag], size: tuple[int, int]) -> ByteImage:
    """(H, W, 4), the labels one below the other as over a pane: for a window of `size`, no wider."""
    height = min(max(size[1] // 40, LEAST), MOST)
    font, pad = ImageFont.load_default(height), height // 2
    texts = [_fitting(legible(one.text), font, size[0] - 4 * pad) for one in labels]
    row, width = 2 * height, max(int(font.getlength(text)) for text in texts) + 4 * pad
    page = Image.new("RGBA", (width, pad + row * len(texts)), (0, 0, 0, 0))
    draw = ImageDraw.Draw(page)
    for place, (text, one) in enumerate(zip(texts, labels, strict=True)):
        top = pad + place * row
        end = pad + int(font.getlength(text)) + 2 * pad, top + row - max(height // 6, 1)
        draw.rounded_rectangle((pad, top, *end), height // 5, _packed(theme.TONES[one.tone]))
        draw.text((2 * pad, (top + end[1]) / 2), text, _packed(theme.INK), font, anchor="lm")
    return np.asarray(page, dtype=np.uint8)


def _fitting(text: str, font: ImageFont.FreeTypeFont | ImageFont.ImageFont, width: float) -> str:
    """As much of it as there is room for."""
    if font.getlength(text) <= width:
        return text
    while text and font.getlength(f"{text}…") > width:
        text = text[:-1]
    return f"{text}…"


def _packed(color: ImVec4) -> tuple[int, int, int, int]:
    red, green, blue, alpha = (round(255 * one) for one in (color.x, color.y, color.z, color.w))
    return red, green, blue, alpha
