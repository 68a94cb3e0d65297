"""How the tools of editing select, as functions on the state."""

from __future__ import annotations

from app.gui.state.app_state import AppState
from app.gui.work.selecting import Limits
from renderer.editing.edits import Combination
from renderer.editing.sight import Trait


def choose_how(state: AppState, how: Combination) -> None:
    """What a new selection does to the one that is there."""
    state.editing.how = how


def choose_radius(state: AppState, radius: float) -> None:
    """Of the sphere or half of the box, in scene distances."""
    state.editing.radius = radius


def move_range(state: AppState, trait: Trait, limits: Limits) -> None:
    """Live, while it is dragged; `edit_actions.select_range` selects with it."""
    state.editing.ranges[trait] = limits
