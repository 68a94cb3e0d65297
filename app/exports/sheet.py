"""A sheet for reports: images side by side at full resolution, captions above, the notice below."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from app.enhancement.frame_enhancer import Pictures
from app.enhancement.methods import EnhancementSettings
from app.enhancement.setting_words import with_method
from app.files.legible import in_utf8
from app.files.provenance import NOTICE
from app.scenes.color_bar import GROUND, INK
from enhance import Statistics
from renderer.clip import ByteImage


@dataclass(frozen=True, eq=False)
class Panel:
    """One picture of the export, with what stands above it."""

    label: str
    """One line or several."""
    image: ByteImage


def describe(pictures: Pictures, say: Callable[[EnhancementSettings, Statistics], str] = with_method) -> str:
    """What the enhancement used."""
    used, params = pictures.statistics, pictures.request.params
    if used is None or params is None:
        return ""
    return say(params, used)


def sheet(panels: Sequence[Panel]) -> ByteImage:
    """(H, W, 3): the panels side by side at their own sizes, a caption above each, the notice below."""
    margin = 8
    size = max(14, max(panel.image.shape[0] for panel in panels) // 32)
    captions = [in_utf8(panel.label).split("\n") for panel in panels]
    head, foot = size // 2 + 3 * size // 2 * max(map(len, captions)), 2 * size
    width = sum(panel.image.shape[1] + margin for panel in panels) - margin
    height = head + max(panel.image.shape[0] for panel in panels) + foot
    page = Image.new("RGB", (width, height), GROUND)
    draw, x = ImageDraw.Draw(page), 0
    for panel, lines in zip(panels, captions, strict=True):
        for place, line in enumerate(lines):
            font = _fitting(line, size, panel.image.shape[1] - size)
            draw.text((x + size // 2, size + 3 * size // 2 * place), line, INK, font, anchor="lm")
        page.paste(Image.fromarray(panel.image), (x, head))
        x += panel.image.shape[1] + margin
    small = _fitting(NOTICE, size * 3 // 4, width - size)
    draw.text((size // 2, height - foot // 2), NOTICE, (170, 170, 170), small, anchor="lm")
    return np.asarray(page, dtype=np.uint8)


def _fitting(text: str, size: int, width: float) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """The built-in font, small enough for `text` to fit into `width` pixels."""
    font = ImageFont.load_default(size)
    shrunk = int(size * width / max(font.getlength(text), 1))
    return font if shrunk >= size else ImageFont.load_default(max(6, shrunk))
