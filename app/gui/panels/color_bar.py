"""The scale of the 3D view's colours, over its right edge."""

from __future__ import annotations

from imgui_bundle import ImVec2, ImVec4, imgui

from app.gui.style import theme
from app.gui.style.widgets import em
from app.scenes.view_kinds import Scale

SEGMENTS = 32


def draw_color_bar(scale: Scale, high: ImVec2, height: float) -> None:
    """Into the current window, below and left of its upper right corner `high`; high values above."""
    draw = imgui.get_window_draw_list()
    texts = [scale.text(tick) for tick in scale.ticks]
    across = em(0.9)
    wide = max(imgui.calc_text_size(text).x for text in texts) + across + em(1.0)
    wide = max(wide, imgui.calc_text_size(scale.unit).x) + em(1.0)
    tall = min(height - em(1.0), em(15))
    left, top = high.x - wide - em(0.5), high.y + em(0.5)
    if tall < em(6):
        return
    ground = imgui.get_color_u32(theme.grey(0.0, 0.62))
    draw.add_rect_filled(ImVec2(left, top), ImVec2(high.x - em(0.5), top + tall), ground, em(0.25))
    ink = imgui.get_color_u32(theme.grey(0.92))
    draw.add_text(ImVec2(left + em(0.5), top + em(0.3)), ink, scale.unit)
    first, last = top + em(1.9), top + tall - em(0.8)
    table = scale.table
    for index in range(SEGMENTS):
        ends = [int(table.shape[0] - 1 - (index + side) / SEGMENTS * (table.shape[0] - 1)) for side in (0, 1)]
        above, below = (_packed(*table[end].tolist()) for end in ends)
        edges = [first + (last - first) * (index + side) / SEGMENTS for side in (0, 1)]
        draw.add_rect_filled_multi_color(
            ImVec2(left + em(0.5), edges[0]),
            ImVec2(left + em(0.5) + across, edges[1]),
            above,
            above,
            below,
            below,
        )
    for tick, text in zip(scale.ticks, texts, strict=True):
        y = last - (tick - scale.low) / (scale.high - scale.low) * (last - first)
        end = left + em(0.5) + across
        draw.add_line(ImVec2(end, y), ImVec2(end + em(0.25), y), ink)
        draw.add_text(ImVec2(end + em(0.45), y - imgui.get_text_line_height() / 2), ink, text)


def _packed(red: int, green: int, blue: int) -> int:
    """As draw lists take a colour, 0 to 255 each."""
    return imgui.get_color_u32(ImVec4(red / 255, green / 255, blue / 255, 1.0))
