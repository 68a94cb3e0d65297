"""The guide, as functions on the state."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from app.gui.state.app_state import AppState
from app.gui.work.shipped import Guide

COUNT: Final = 6
"""Pages."""
TITLE: Final = "Guide"
PAGES: Final = {
    "Images": 0, "Enhancement": 1, "Report": 2, "Tuning": 1, "Enhance files and folders": 1,
    "Reconstruction": 3, "Masks": 3, "Runs": 3, "Log": 3,
    "3D view": 4, "Splat file": 4, "Cameras": 4, "Edit": 4,
    "Export": 5, "Notes": 5,
}  # fmt: skip
"""Of each panel, the page that is about it."""


def open_about(state: AppState, panel: str) -> None:
    """At the page of a panel; on the guide itself, close it."""
    if panel == TITLE:
        state.guide.shown = False
        return
    state.guide.shown = True
    if panel == "Images" and not state.is_empty:
        turn_to(state, 2)
    elif panel in PAGES:
        turn_to(state, PAGES[panel])


def turn(state: AppState, pages: int) -> None:
    """Turn so many pages on, or back where negative."""
    turn_to(state, state.guide.page + pages)


def turn_to(state: AppState, page: int) -> None:
    state.guide.page = min(max(page, 0), COUNT - 1)


def take_guide(state: AppState, request: Path, guide: Guide) -> None:
    state.guide.pages = guide
