"""What the two 3D views should show, smaller while they move where a whole one takes long."""

from __future__ import annotations

from app.gui.state.app_state import AppState
from app.scenes.view_request import ViewRequest
from app.scenes.viewing import View

SLOW_VIEW = 60.0
"""Milliseconds above which the 3D view is drawn smaller while it moves."""
REDUCED = 0.5


def first_wish(state: AppState) -> ViewRequest | None:
    """Of the processor; None where the card draws."""
    return view_request(state) if state.scene.processor_draws else None


def second_wish(state: AppState) -> ViewRequest | None:
    """Of the first one's moment, camera and size."""
    return beside(state, first_wish(state))


def beside(state: AppState, first: ViewRequest | None) -> ViewRequest | None:
    """The second view beside a first one of the processor's."""
    return None if first is None or not state.scene.processor_draws else state.scene.beside(first)


def view_request(state: AppState) -> ViewRequest | None:
    """What the 3D view should show, smaller while it moves when a whole one takes long."""
    request = state.view_request
    moving = (
        state.scene.dragged
        or state.scene.viewer.moving
        or state.timeline.playing
        or state.scene.cameras.playing
    )
    if request is None or not moving or not is_slow(state.scene.view, state.scene.second.view):
        return request
    return request.scaled(REDUCED)


def is_slow(*views: View | None) -> bool:
    """Whether the last pictures together would have taken long at full size."""
    shares = [(view.milliseconds, view.request.reduced) for view in views if view is not None]
    return sum(spent / REDUCED**2 if reduced else spent for spent, reduced in shares) > SLOW_VIEW
