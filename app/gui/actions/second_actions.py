"""What a user can do with the second 3D view, as functions on the state."""

from __future__ import annotations

from pathlib import Path

from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.state.second import Second
from app.gui.work.opening import Opened, OpenRequest


def open_second(state: AppState, path: Path) -> None:
    """Ask for a finished run or a file of splats, to be seen beside the first."""
    if state.model is not None:
        state.second.opening = OpenRequest(path.absolute(), state.clip_options)
        state.banner = None


def take_second(state: AppState, request: OpenRequest, opened: Opened) -> None:
    """Show what has been opened; what has no reconstruction is refused."""
    if request is not state.second.opening:
        return
    shown = opened.splats or (opened.run.model if opened.run is not None else None)
    state.second.opening = None
    if shown is None:
        actions.fail(state, f"expected a finished run or a splat file beside the first: {request.path}")
        return
    state.second = Second(shown=shown)
    if state.model is not None and shown.first != state.model.first:
        actions.say(
            state, f"{shown.name} covers another part of the clip: the same time is a different moment"
        )
    elif state.model is not None and shown.cameras != state.model.cameras:
        actions.say(state, f"{shown.name} is of another clip: the first one's camera may not see it")


def refuse_second(state: AppState, request: OpenRequest, reason: str) -> None:
    """It cannot be opened; what is beside the first stays."""
    if request is state.second.opening:
        state.second.opening = None
        actions.fail(state, reason)


def close_second(state: AppState) -> None:
    state.second = Second()
