"""Labels over images."""

from __future__ import annotations

from collections.abc import Iterable

from imgui_bundle import ImVec2, ImVec4, imgui

from app.files.legible import legible
from app.gui.state.tags import Tag
from app.gui.style import theme
from app.gui.style.widgets import em

ROOM = 1e4
"""Pixels that no label needs."""


def tag(text: str, position: ImVec2, color: ImVec4, room: float = ROOM) -> float:
    """A label on a picture, in lines where it has to be; `position` is its upper left corner.

    `room`: pixels from there to the right edge. Returns its height.
    """
    text, pad, wrap = legible(text), ImVec2(em(0.45), em(0.18)), _inner(room)
    size = imgui.calc_text_size(text, wrap_width=wrap) + pad * 2
    draw, ink = imgui.get_window_draw_list(), imgui.get_color_u32(theme.INK)
    draw.add_rect_filled(position, position + size, imgui.get_color_u32(color), em(0.2))
    draw.add_text(imgui.get_font(), imgui.get_font_size(), position + pad, ink, text, wrap_width=wrap)
    return size.y


def _inner(room: float) -> float:
    """The width that the text of a tag may have, never less than a short word's."""
    return max(room - em(0.9), em(4))


def tag_height(text: str, room: float) -> float:
    """That `tag` would return."""
    return imgui.calc_text_size(legible(text), wrap_width=_inner(room)).y + em(0.36)


def stack_tags(tags: Iterable[Tag], corner: ImVec2, width: float) -> None:
    """Labels one below the other in the upper left corner of a picture so wide."""
    y = corner.y + em(0.4)
    for one in tags:
        at = ImVec2(corner.x + em(0.4), y)
        y += tag(one.text, at, theme.TONES[one.tone], width - em(0.8)) + em(0.14)
