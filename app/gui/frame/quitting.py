"""The window closes only when nothing is lost, or after the user has agreed."""

from __future__ import annotations

import glfw
from imgui_bundle import glfw_utils, hello_imgui

from app.files.legible import legible
from app.gui.actions import closing, session_actions
from app.gui.frame import dockings
from app.gui.state.app_state import AppState
from app.gui.style.asking import ask
from renderer.listing import count


def ask_before_quitting(state: AppState) -> None:
    """What is unsaved and reconstructions under way keep the window open until a person has answered.

    The runner looks at the wish to quit between two frames: to be called last in a frame.
    """
    params = hello_imgui.get_runner_params()
    if params.app_shall_exit:
        changed = session_actions.look_for_changes(state) or session_actions.loses_case(state)
        unsaved = changed or state.editing.is_unsaved
        if unsaved or not closing.may_close(state):
            params.app_shall_exit = False
            glfw.set_window_should_close(glfw_utils.glfw_window_hello_imgui(), 0)
        if unsaved:
            closing.answer_closing(state, close=False)
            session_actions.leave_case(state, dockings.quit_app)
    _draw_unsaved(state)
    _draw_new_case(state)
    _draw_question(state)


def _draw_unsaved(state: AppState) -> None:
    """Before changes of a session that has a file are lost, or a case that has none."""
    kept = state.session
    if kept.leaving is None:
        return
    if kept.path is not None:
        title, save = "Unsaved changes", "Save"
        said = f"{legible(kept.path.name)} has changed since it was saved."
    else:
        title, save = "Unsaved case", "Save session…"
        said = f"Not saved in a session yet: {case_in_words(state)}."
    if reply := ask(title, (said,), (save, "Discard", "Stay")):
        session_actions.answer(state, "save" if reply == save else reply.lower())


def case_in_words(state: AppState) -> str:
    """What there is of notes and images."""
    summary = state.summary
    said = ["the notes"] if state.session.notes or summary.notes else []
    said += [f"{count(len(summary.items), 'image')} of the case summary"] if summary.items else []
    return " and ".join(said) or "the case summary"


def _draw_new_case(state: AppState) -> None:
    """Before notes and case summary begin anew."""
    if not state.session.asks_new_case:
        return
    said = f"This clears {case_in_words(state)} from the window. Saved files stay."
    if reply := ask("Begin a new case?", (said,), ("Begin", "Keep")):
        session_actions.answer_new_case(state, agreed=reply == "Begin")


def _draw_question(state: AppState) -> None:
    if state.window.closing != "asked":
        return
    said = (closing.at_stake(state), closing.what_is_kept(state))
    # All may have ended while the question stood there.
    reply = ask("Close VesselSplat?", said, ("Close", "Stay"), moot=not said[0])
    if reply:
        closing.answer_closing(state, close=reply == "Close")
    if reply == "Close":
        dockings.quit_app()
    elif reply:
        session_actions.keep_case(state)
