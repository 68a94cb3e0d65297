"""What the program is, and its log, as functions on the state."""

from __future__ import annotations

from app.gui.state.app_state import AppState
from app.gui.work.about import About
from app.gui.work.revealing import RevealRequest


def take_about(state: AppState, request: str, about: About) -> None:
    state.about.facts = about


def open_log_folder(state: AppState) -> None:
    """Show the folder of the log in the desktop's file manager."""
    state.window.wishes += (RevealRequest(state.places.logs),)
