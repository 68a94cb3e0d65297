"""What a user can have the 3D view show, as functions on the state."""

from __future__ import annotations

from app.gui.actions import camera_actions
from app.gui.state.app_state import AppState
from app.scenes.view_kinds import EXPLAINED, ViewKind


def choices(state: AppState) -> tuple[ViewKind, ...]:
    """The views that this model has: without photos there is no difference to them."""
    return tuple(kind for kind in EXPLAINED if kind != "difference" or state.has_photos)


def choose_view(state: AppState, kind: ViewKind) -> None:
    """A difference is to the photo, so it is seen through the clip's camera."""
    state.scene.kind = kind
    if kind == "difference" and not state.scene.viewer.snapped:
        camera_actions.toggle_snap(state)


def next_view(state: AppState) -> None:
    if state.scene.model is not None:
        kinds = choices(state)
        now = kinds.index(state.scene.kind) if state.scene.kind in kinds else -1
        choose_view(state, kinds[(now + 1) % len(kinds)])
