"""What the next reconstruction shall be, as functions on the state."""

from __future__ import annotations

from dataclasses import replace

from app.enhancement.settable import LONGEST_NAME, InputKind
from app.gui.state.app_state import AppState
from renderer.train.config import Method


def choose_input(state: AppState, frames: InputKind) -> None:
    """The photos as they are, enhanced, or both in turn."""
    state.runs.reconstruction.input = frames


def choose_d_factor(state: AppState, d_factor: float) -> None:
    """Of frames that are enhanced for it."""
    state.runs.reconstruction.d_factor = d_factor


def choose_method(state: AppState, method: Method, iterations: int) -> None:
    draft = state.runs.reconstruction
    draft.config = replace(draft.config, method=method, iterations=iterations)


def name_run(state: AppState, name: str) -> None:
    """Folder of the run; empty: the clip's name and the time."""
    state.runs.reconstruction.name = name[:LONGEST_NAME]
