"""What a person can do with the reconstructions that wait, as functions on the state. No ImGui."""

from __future__ import annotations

from app.gui.actions import job_actions
from app.gui.actions.job_actions import MakeJob
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import Waiting


def advance(state: AppState, make_job: MakeJob) -> None:
    """Once a frame: when one has ended, in whatever way, the next starts."""
    run = state.reconstruction
    if state.queue and not run.is_alive and run.job is None and not why_held(state):
        job_actions.start_first(state, make_job)


def why_held(state: AppState) -> str:
    """Why the next one does not start by itself, in a sentence; empty when it does."""
    editing = state.editing
    if editing.active or editing.is_unsaved or editing.leaving is not None:
        return "The next one starts when editing has ended and the edits are saved or discarded."
    return ""


def withdraw(state: AppState, waiting: Waiting) -> None:
    """It is not made; nothing of it is on disk yet that was not there before."""
    state.queue = tuple(each for each in state.queue if each is not waiting)


def to_front(state: AppState, waiting: Waiting) -> None:
    """It is the next one."""
    if waiting in state.queue:
        state.queue = (waiting, *(each for each in state.queue if each is not waiting))


# ---- closing the window


def at_stake(state: AppState) -> str:
    """What closing the window would end, in a sentence; empty when it ends nothing."""
    run, count = state.reconstruction, len(state.queue)
    waits = "1 more waits" if count == 1 else f"{count} more wait"
    if run.is_alive:
        name = run.run_path.name if run.run_path else "A reconstruction"
        return f"{name} is still being made{f', and {waits}' if count else ''}."
    return f"{'1 reconstruction waits' if count == 1 else f'{count} reconstructions wait'}." if count else ""


def may_close(state: AppState) -> bool:
    """Whether the window can close without a question; else the question is asked."""
    if state.closing == "agreed" or not at_stake(state):
        return True
    state.closing = "asked"
    return False


def answer_closing(state: AppState, *, close: bool) -> None:
    state.closing = "agreed" if close else "no"
