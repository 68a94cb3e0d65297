"""The clip's time, below everything: play, step, scrub."""

from __future__ import annotations

from collections.abc import Callable

from imgui_bundle import icons_fontawesome_4 as icons
from imgui_bundle import imgui

from app.gui import actions
from app.gui.state import AppState
from app.gui.widgets import button, em, explain


def draw_timeline(state: AppState, screenshot: Callable[[], None]) -> None:
    """One row; greyed out without a clip."""
    count = 1 if state.clip is None else len(state.clip)
    imgui.begin_disabled(count < 2)
    play = icons.ICON_FA_PAUSE if state.playing else icons.ICON_FA_PLAY
    button(f"{icons.ICON_FA_STEP_BACKWARD}##back", lambda: actions.step(state, -1), width=2.2)
    explain("comma: one frame back")
    imgui.same_line(0, em(0.2))
    button(f"{play}###play", lambda: actions.toggle_play(state), width=3)
    explain("P or K: play and pause")
    imgui.same_line(0, em(0.2))
    button(f"{icons.ICON_FA_STEP_FORWARD}##on", lambda: actions.step(state, 1), width=2.2)
    explain("full stop: one frame on")
    imgui.same_line()
    imgui.set_next_item_width(-em(9.2))
    label = f"frame %d / {count}"
    flags = imgui.SliderFlags_.always_clamp
    changed, frame = imgui.slider_int("##frame", state.frame_index + 1, 1, max(count, 2), label, flags)
    if changed:
        actions.seek(state, frame - 1)
    imgui.end_disabled()
    imgui.same_line()
    something = state.pictures is not None or state.model is not None
    button(f"{icons.ICON_FA_CAMERA}  Save picture", screenshot, enabled=something, width=-1.0)
    explain("S: original, enhanced and 3D view side by side, with everything needed to make them again")
