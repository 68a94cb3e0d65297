"""Where windows go that float over the panels."""

from __future__ import annotations

import math

from imgui_bundle import ImVec2, imgui

from app.gui.style.widgets import em


def floating(title: str, width: float, taken: float) -> int:
    """Places the next window and returns its flags: `width` text heights across, in the middle at first, as
    high as its content or as there is room; always below the `taken` pixels at the top, and over the status
    bar only where it is dragged there.

    Its content is to be drawn in the frame that closes it, too: it comes back as high as it was then.
    """
    viewport, when = imgui.get_main_viewport(), imgui.Cond_
    top, end = viewport.work_pos.y + taken, viewport.work_pos.y + viewport.work_size.y - em(1.5)
    shown = _as_shown(title)
    if taken and shown is not None and shown.pos.y < top:
        imgui.set_next_window_pos(ImVec2(shown.pos.x, top), when.always)
    elif shown is not None and _has_less_room(shown, end - shown.size.y):
        imgui.set_next_window_pos(ImVec2(shown.pos.x, max(end - shown.size.y, top)), when.always)
    else:
        middle = viewport.get_center() + ImVec2(0, taken / 2)
        imgui.set_next_window_pos(middle, when.appearing, ImVec2(0.5, 0.5))
    across, down = min(em(width), viewport.work_size.x), viewport.work_size.y - em(3) - taken
    imgui.set_next_window_size_constraints(ImVec2(across, 0), ImVec2(across, down))
    flags = imgui.WindowFlags_
    return int(flags.no_collapse | flags.no_docking | flags.always_auto_resize)


def _has_less_room(window: imgui.internal.Window, lowest: float) -> bool:
    """The window has grown or the screen shrunk, so that with its top below `lowest` its end is out of
    sight."""
    kept, key = window.state_storage, window.get_id("lowest")
    before = kept.get_float(key, math.nan)
    kept.set_float(key, lowest)
    return lowest != before and window.pos.y > lowest


def _as_shown(title: str) -> imgui.internal.Window | None:
    """The window of that title; None before it has been drawn in its place."""
    window: imgui.internal.Window | None = imgui.internal.find_window_by_name(title)
    return window if window is not None and window.was_active and not window.hidden else None
