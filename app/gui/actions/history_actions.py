"""Undo and redo of all that a user sets, as functions on the state: one history of snapshots."""

from __future__ import annotations

from dataclasses import replace

from app.gui.actions import actions, clip_actions, depth_actions, enhancement_actions
from app.gui.state.app_state import AppState
from app.gui.state.enhancement import SettingsSnapshot, step_name


def undo(state: AppState) -> None:
    enhancement_actions.settle_params(state)
    if len(state.enhancement.past) > 1:
        state.enhancement.future.append(state.enhancement.past.pop())
        _take(state, state.enhancement.past[-1])


def redo(state: AppState) -> None:
    if state.enhancement.future:
        state.enhancement.past.append(state.enhancement.future.pop())
        _take(state, state.enhancement.past[-1])


def undo_name(state: AppState) -> str:
    """The name of the command Undo, with what it would take back."""
    return f"Undo {step_name(*state.enhancement.past[-2:])}" if len(state.enhancement.past) > 1 else "Undo"


def redo_name(state: AppState) -> str:
    past, future = state.enhancement.past, state.enhancement.future
    return f"Redo {step_name(past[-1], future[-1])}" if future else "Redo"


def _take(state: AppState, chosen: SettingsSnapshot) -> None:
    now, draft, used = state.comparing.chosen, state.runs.reconstruction, state.enhancement
    used.params, used.scope, used.pixels = chosen.params, chosen.scope, chosen.pixels
    state.comparing.chosen = replace(chosen.comparison, wipe=now.wipe, flipped=now.flipped)
    draft.config, draft.input, draft.kept = chosen.config, chosen.input, chosen.kept
    baseline, view = chosen.baseline, chosen.field_of_view
    reading = replace(state.source.reading, depth=chosen.depth, baseline=baseline, field_of_view=view)
    if reading != state.source.reading:
        depth_actions.choose_reading(state, reading)
    _take_kept(state, chosen)
    if state.source.part != chosen.part:
        state.source.part = chosen.part
        clip_actions.keep_settings(state)


def _take_kept(state: AppState, chosen: SettingsSnapshot) -> None:
    """Take views and images, and say so: their panels may be hidden."""
    cameras, summary = state.scene.cameras, state.summary
    if cameras.views != chosen.views:
        cameras.views = chosen.views
        kept = f"saved views: {len(chosen.views.named)}, keyframes: {len(chosen.views.path.keyframes)}"
        actions.announce(state, kept)
    if summary.items != chosen.images:
        summary.items = chosen.images
        actions.announce(state, f"images in the case summary: {len(chosen.images)}")
