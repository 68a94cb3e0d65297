"""Follows the one-time preparation, which goes on in a process of its own."""

from __future__ import annotations

from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.kernels.preparer import Preparer

COMPLETE = "the one-time preparation is complete"
ENDED = "the one-time preparation ended early: the first use of a method may take a minute"


def follow_preparation(state: AppState, preparer: Preparer | None) -> None:
    """Once a frame: how far it is. Should it end early, kernels are compiled where they are first used."""
    if preparer is None:
        return
    before, state.window.preparation = state.window.preparation, preparer.poll()
    if before is not None and state.window.preparation is None:
        actions.say(state, COMPLETE if preparer.is_complete else ENDED)
