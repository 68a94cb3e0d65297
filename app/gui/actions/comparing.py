"""What a user can do with the two panes, as functions on the state."""

from __future__ import annotations

from dataclasses import replace

from app.enhancement.settable import Mode, Slot
from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.state.comparison import Side

WIPE_STEP = 0.02


def choose_mode(state: AppState, mode: Mode) -> None:
    """Compare in this way; asked for again, side by side."""
    now = state.comparison.mode
    state.comparison = replace(state.comparison, mode="side by side" if mode == now else mode, flipped=False)


def flip(state: AppState) -> None:
    """One pane that changes between left and right, and stays so until it is flipped again."""
    now = state.comparison
    flipped = not now.flipped if now.mode == "flip" else True
    state.comparison = replace(now, mode="flip", flipped=flipped)


def choose_source(state: AppState, side: Side, source: str) -> None:
    """Show something else on one side."""
    state.comparison = state.comparison.showing(side, source)
    state.enhancing = True


def swap(state: AppState) -> None:
    now = state.comparison
    state.comparison = replace(now, left=now.right, right=now.left)


def reset_sources(state: AppState) -> None:
    """Left the original, right the enhanced."""
    state.comparison = state.comparison.renewed()


def move_wipe(state: AppState, by: float) -> None:
    """Move the line of the wipe by a share of the pane, where there is one."""
    if state.comparison.mode == "wipe":
        state.comparison = state.comparison.wiped(state.comparison.wipe + by)


def toggle_zebra(state: AppState) -> None:
    state.comparison = replace(state.comparison, zebra=not state.comparison.zebra)


def store(state: AppState, slot: Slot) -> None:
    """Keep the present setting, to be compared with and gone back to."""
    state.stored = state.stored | {slot: state.params}
    actions.announce(state, f"settings stored as {slot}; choose them above the panes")


def recall(state: AppState, slot: Slot) -> None:
    """The stored setting becomes the present one; a step of undo."""
    if slot in state.stored:
        actions.settle_params(state)
        actions.set_params(state, state.stored[slot])
        state.enhancing = True
