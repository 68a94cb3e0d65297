"""Choosing, keeping and forgetting presets, as functions on the state."""

from __future__ import annotations

from app.enhancement.methods import EnhancementSettings
from app.enhancement.settable import LONGEST_NAME
from app.gui.actions import actions, enhancement_actions
from app.gui.state.app_state import AppState
from app.gui.work.background import Failure
from app.gui.work.presets import (
    MOST_PRESETS,
    KeepPresets,
    is_preset_name,
    load_presets,
    presets_file,
    presets_with,
)
from app.gui.work.thumbnails import Thumbnails, ThumbnailsRequest


def load(state: AppState) -> None:
    """At the start: own presets of earlier sessions."""
    state.enhancement.presets, trouble = load_presets(presets_file(state.places))
    if trouble:
        actions.fail(state, trouble)


def type_name(state: AppState, name: str) -> None:
    """Of the preset that is to be kept."""
    state.enhancement.preset_draft = name[:LONGEST_NAME]


def look_at(state: AppState, open_: bool) -> None:
    """The menu of presets is open, or not any more."""
    state.enhancement.choosing = open_


def take_thumbnails(state: AppState, request: ThumbnailsRequest, thumbnails: Thumbnails) -> None:
    state.enhancement.thumbnails = thumbnails


def choose(state: AppState, name: str) -> None:
    """The preset becomes the present setting; a step of undo."""
    presets = presets_with(state.enhancement.presets)
    if name in presets:
        enhancement_actions.settle_params(state)
        enhancement_actions.set_params(state, presets[name])
        state.enhancement.active = True


def replaced(state: AppState) -> str:
    """The own preset that keeping under the typed name would replace; empty for none."""
    name = _kept_name(state.enhancement.preset_draft)
    return name if name in state.enhancement.presets else ""


def _kept_name(typed: str) -> str:
    return typed.strip()[:LONGEST_NAME]


def keep(state: AppState, name: str) -> None:
    """The present setting under this name, in place of an own preset of the same name."""
    name = _kept_name(name)
    if not is_preset_name(name):
        actions.fail(state, "expected a name other than those of the built-in presets")
        return
    if len(state.enhancement.presets | {name: state.enhancement.params}) > MOST_PRESETS:
        actions.fail(state, f"expected at most {MOST_PRESETS} presets: delete some first")
        return
    done = f"preset {name} replaced" if name in state.enhancement.presets else f"saved as preset {name}"
    _save(state, {**state.enhancement.presets, name: state.enhancement.params}, done)


def ask_forget(state: AppState, name: str) -> None:
    """Whether an own preset is to be deleted."""
    state.enhancement.preset_doomed = name


def answer_forget(state: AppState, *, delete: bool) -> None:
    name, state.enhancement.preset_doomed = state.enhancement.preset_doomed, ""
    if delete:
        forget(state, name)


def forget(state: AppState, name: str) -> None:
    """Delete an own preset."""
    left = {known: params for known, params in state.enhancement.presets.items() if known != name}
    _save(state, left, f"preset {name} deleted")


def ask_rename(state: AppState, name: str) -> None:
    """Which name an own preset shall have."""
    state.enhancement.preset_renamed = state.enhancement.preset_draft = name


def why_not_rename(state: AppState) -> str:
    """To what is typed, in a sentence; empty when it can be."""
    name = _kept_name(state.enhancement.preset_draft)
    if not name:
        return "Type a name."
    if not is_preset_name(name):
        return "A built-in preset has this name."
    taken = name in state.enhancement.presets and name != state.enhancement.preset_renamed
    return "Another preset has this name." if taken else ""


def answer_rename(state: AppState, *, rename: bool) -> None:
    """The question is gone; under its new name the preset is the same."""
    reason, presets = why_not_rename(state), state.enhancement.presets
    before, state.enhancement.preset_renamed = state.enhancement.preset_renamed, ""
    name = _kept_name(state.enhancement.preset_draft)
    if rename and not reason and name != before and before in presets:
        left = {known: params for known, params in presets.items() if known != before}
        _save(state, {**left, name: presets[before]}, f"preset {before} renamed to {name}")


def _save(state: AppState, presets: dict[str, EnhancementSettings], done: str) -> None:
    state.window.wishes += (
        KeepPresets(presets_file(state.places), presets, state.enhancement.presets, done),
    )


def take_kept(
    state: AppState, request: KeepPresets, answer: dict[str, EnhancementSettings] | Failure
) -> None:
    """They are on disk, or cannot be kept and are as before."""
    if isinstance(answer, Failure):
        actions.fail(state, f"the presets cannot be saved: {answer.placed}")
        return
    state.enhancement.presets = answer
    actions.announce(state, request.done)
