"""How large and how fine exports are, as functions on the state."""

from __future__ import annotations

from app.exports.sizing import Sizing
from app.gui.state.app_state import AppState


def show_exports(state: AppState, shown: bool) -> None:
    """The panel."""
    state.exports.shown = shown


def choose_sizing(state: AppState, sizing: Sizing) -> None:
    """Of the panes."""
    state.exports.sizing = sizing


def choose_view_size(state: AppState, size: tuple[int, int] | None) -> None:
    """Pixels of the 3D view in files; None: its shape on screen."""
    state.exports.view_size = size


def choose_supersampling(state: AppState, factor: int) -> None:
    """How often finer the 3D view is drawn, one of FACTORS."""
    state.exports.supersampling = factor
