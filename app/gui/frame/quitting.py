"""The window closes only when nothing is lost, or after the user has agreed."""

from __future__ import annotations

import glfw
from imgui_bundle import ImVec2, glfw_utils, hello_imgui, imgui, imgui_ctx

from app.gui.actions import actions, queue_actions
from app.gui.frame import dockings
from app.gui.state.app_state import AppState
from app.gui.style.widgets import em, question


def ask_before_quitting(state: AppState) -> None:
    """Unsaved edits and reconstructions under way keep the window open until a person has answered.

    The runner looks at the wish to quit between two frames: to be called last in a frame.
    """
    params = hello_imgui.get_runner_params()
    if params.app_shall_exit and (state.editing.is_unsaved or not queue_actions.may_close(state)):
        params.app_shall_exit = False
        glfw.set_window_should_close(glfw_utils.glfw_window_hello_imgui(), 0)
        if state.editing.is_unsaved:
            queue_actions.answer_closing(state, close=False)
            actions.leave(state, dockings.quit_app)
    _draw_question(state)


def _draw_question(state: AppState) -> None:
    if state.window.closing != "asked":
        return
    with question("Close VesselSplat?", 27) as opened:
        if not opened:
            return
        with imgui_ctx.push_text_wrap_pos(0):
            imgui.text_unformatted(queue_actions.at_stake(state))
            imgui.text_unformatted(queue_actions.what_is_kept(state))
        imgui.spacing()
        half = (imgui.get_content_region_avail().x - em(0.5)) / 2
        close = imgui.button("Close", ImVec2(half, em(2)))
        imgui.same_line(0, em(0.5))
        stay = imgui.button("Stay", ImVec2(half, em(2))) or imgui.is_key_pressed(imgui.Key.escape)
        # All may have ended while the question stood there.
        if close or stay or not queue_actions.at_stake(state):
            imgui.close_current_popup()
            queue_actions.answer_closing(state, close=close)
        if close:
            dockings.quit_app()
