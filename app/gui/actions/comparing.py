"""What a user can do with the two panes, as functions on the state."""

from __future__ import annotations

from dataclasses import replace

from app.enhancement.settable import Mode, Slot
from app.gui.actions import actions, enhancement_actions
from app.gui.state.app_state import AppState
from app.gui.views.comparison import Side

WIPE_STEP = 0.02


def choose_mode(state: AppState, mode: Mode) -> None:
    """Compare in this way; asked for again, side by side."""
    now = state.comparing.chosen.mode
    state.comparing.chosen = replace(
        state.comparing.chosen, mode="side by side" if mode == now else mode, flipped=False
    )


def flip(state: AppState) -> None:
    """One pane that changes between left and right, and stays so until it is flipped again."""
    now = state.comparing.chosen
    flipped = not now.flipped if now.mode == "flip" else True
    state.comparing.chosen = replace(now, mode="flip", flipped=flipped)


def choose_source(state: AppState, side: Side, source: str) -> None:
    """Show something else on one side."""
    state.comparing.chosen = state.comparing.chosen.showing(side, source)
    state.enhancement.active = True


def swap(state: AppState) -> None:
    now = state.comparing.chosen
    state.comparing.chosen = replace(now, left=now.right, right=now.left)


def reset_sources(state: AppState) -> None:
    """Left the original, right the enhanced."""
    state.comparing.chosen = state.comparing.chosen.renewed()


def move_wipe(state: AppState, by: float) -> None:
    """Move the line of the wipe by a share of the pane, where there is one."""
    if state.comparing.chosen.mode == "wipe":
        set_wipe(state, state.comparing.chosen.wipe + by)


def set_wipe(state: AppState, wipe: float) -> None:
    """The line of the wipe, as a share of the pane's width."""
    state.comparing.chosen = state.comparing.chosen.wiped(wipe)


def toggle_zebra(state: AppState) -> None:
    state.comparing.chosen = replace(state.comparing.chosen, zebra=not state.comparing.chosen.zebra)


def store(state: AppState, slot: Slot) -> None:
    """Keep the present setting, to be compared with and gone back to."""
    state.enhancement.stored = state.enhancement.stored | {slot: state.enhancement.params}
    actions.announce(state, f"settings stored as {slot}; choose them above the panes")


def recall(state: AppState, slot: Slot) -> None:
    """The stored setting becomes the present one; a step of undo."""
    if slot in state.enhancement.stored:
        enhancement_actions.settle_params(state)
        enhancement_actions.set_params(state, state.enhancement.stored[slot])
        state.enhancement.active = True
