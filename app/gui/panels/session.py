"""Notes of the session, and the offer to restore one that ended unexpectedly."""

from __future__ import annotations

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.gui.actions import session_actions
from app.gui.state.app_state import AppState
from app.gui.style.widgets import em, explain

OFFER = "An earlier session ended unexpectedly"


def draw_notes(state: AppState) -> None:
    """What a person writes down; kept with the session."""
    space = imgui.get_content_region_avail()
    size = ImVec2(-1, max(space.y, em(3)))
    changed, text = imgui.input_text_multiline("##notes", state.session.notes, size)
    explain("Saved with the session (Ctrl+S) and recovered after a crash. Not included in exports.")
    if changed:
        session_actions.write_notes(state, text)


def draw_recovery(state: AppState) -> None:
    """Once at the start, after the notice."""
    if state.session.recoverable is None or not state.settings.acknowledged:
        return
    imgui.open_popup(OFFER)
    center = imgui.get_main_viewport().get_center()
    imgui.set_next_window_pos(center, imgui.Cond_.always, ImVec2(0.5, 0.5))
    flags = imgui.WindowFlags_.no_resize | imgui.WindowFlags_.no_move | imgui.WindowFlags_.always_auto_resize
    with imgui_ctx.begin_popup_modal(OFFER, flags) as opened:
        if not opened:
            return
        imgui.spacing()
        if state.session.recoverable_since:
            imgui.text_unformatted(f"It was last saved {state.session.recoverable_since}.")
        imgui.text_unformatted("Restore the open files, settings, views and notes?")
        imgui.spacing()
        for label, act in (("Restore", session_actions.recover), ("Start fresh", session_actions.decline)):
            if imgui.button(label, ImVec2(em(12), em(2))):
                act(state)
                imgui.close_current_popup()
            imgui.same_line()
