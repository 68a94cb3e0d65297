"""What Escape leaves: the innermost thing that is open, and nothing else. Functions on the state."""

from __future__ import annotations

from collections.abc import Callable

from app.gui.actions import camera_actions, clip_actions, edit_actions
from app.gui.state.app_state import AppState

Leave = Callable[[AppState], bool]
"""Leaves one kind of thing. False: it is not open."""


def leave_innermost(state: AppState) -> bool:
    """Dialogs before tools, a drag before the tool that it is made with; menus and questions have closed by
    then. False where there is nothing to leave."""
    return any(leave(state) for leave in INNERMOST_FIRST)


def _help(state: AppState) -> bool:
    was, state.window.help_open = state.window.help_open, False
    return was


def _export(state: AppState) -> bool:
    was, state.exports.shown = state.exports.shown, False
    return was


def _batches(state: AppState) -> bool:
    was, state.batches.shown = state.batches.shown, False
    return was


def _mask(state: AppState) -> bool:
    was = bool(state.picture.mask_tool)
    if was:
        clip_actions.stop_mask(state)
    return was


def _stroke(state: AppState) -> bool:
    was = bool(state.editing.stroke)
    if was:
        edit_actions.drop_stroke(state)
    return was


def _editing(state: AppState) -> bool:
    was = state.editing.active
    if was:
        edit_actions.toggle(state)
    return was


def _measuring(state: AppState) -> bool:
    was = state.scene.viewer.measuring
    if was:
        camera_actions.toggle_measuring(state)
    return was


def _flight(state: AppState) -> bool:
    was = state.scene.viewer.flying
    if was:
        camera_actions.toggle_flight(state)
    return was


def _bare(state: AppState) -> bool:
    was, state.window.bare = state.window.bare, False
    return was


def _full_screen(state: AppState) -> bool:
    was, state.window.full_screen = state.window.full_screen, False
    return was


INNERMOST_FIRST: tuple[Leave, ...] = (
    _help, _export, _batches, _mask, _stroke, _measuring, _flight, _editing,
    _bare, _full_screen,
)  # fmt: skip
