"""Sliders with their number in their middle, which stays legible over the handle."""

from __future__ import annotations

import math

from imgui_bundle import ImVec4, imgui, imgui_ctx

from app.gui.style import theme
from app.gui.views.frame_scale import PADDING


def slide_labelled(
    name: str, value: float, low: float, high: float, form: str, flags: int = 0
) -> tuple[bool, float]:
    """ImGui's slider of a number from `low` up to `high`: whether it is moved, and to what."""
    width, grab = imgui.calc_item_width(), imgui.get_style().grab_min_size
    left = PADDING + _share(value, low, high, flags) * (width - 2 * PADDING - grab)
    color, kind = handle(form % value, (left, left + grab), width), imgui.Col_
    with (
        imgui_ctx.push_style_color(kind.slider_grab, color),
        imgui_ctx.push_style_color(kind.slider_grab_active, color),
    ):
        changed, new = imgui.slider_float(name, value, low, high, form, flags)
    return changed, new


def _share(value: float, low: float, high: float, flags: int) -> float:
    """Of the way that the handle has gone, in [0, 1]."""
    if high <= low:
        return 0.0
    value = min(max(value, low), high)
    if flags & imgui.SliderFlags_.logarithmic:
        return math.log(value / low) / math.log(high / low)
    return (value - low) / (high - low)


def handle(label: str, ends: tuple[float, float], width: float) -> ImVec4:
    """The colour of a handle between these ends of a slider so many pixels across: one that leaves the label
    legible while it is below that."""
    middle, half = width / 2, imgui.calc_text_size(label).x / 2
    below = ends[0] < middle + half and ends[1] > middle - half
    return theme.now().lit if below else theme.now().grab
