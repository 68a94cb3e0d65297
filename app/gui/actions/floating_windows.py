"""Windows that float over the panels, as functions on the part of the state that each is of."""

from __future__ import annotations

from typing import Protocol

from app.gui.state.app_state import AppState


class Floating(Protocol):
    """The guide, the export, and others."""

    shown: bool


def show(window: Floating, shown: bool) -> None:
    window.shown = shown


def toggle(window: Floating) -> None:
    """It comes back as it was left: a guide at the same page."""
    window.shown = not window.shown


def close_all(state: AppState) -> None:
    """What is done behind them goes on."""
    state.window.help_open = False
    parts: tuple[Floating, ...] = (
        state.about, state.guide, state.live.choice, state.exports, state.summary, state.batches
    )  # fmt: skip
    for window in parts:
        show(window, False)
