"""What drawing reports back, as functions on the state: sizes, the pointer, what is on screen."""

from __future__ import annotations

from typing import Protocol

from app.gui.state.app_state import AppState


class Asked(Protocol):
    """What has a panel that is to come to the front."""

    asked: bool


def came(part: Asked) -> None:
    """Its panel is in front."""
    part.asked = False


def point(state: AppState, pointer: tuple[int, int] | None) -> None:
    """Column and row of the picture under the pointer."""
    state.picture.pointer = pointer


def place_wipe(state: AppState, across: float) -> None:
    """Where the line of the wipe stands in the picture, as a share of its width."""
    state.comparing.wiped = min(max(across, 0.0), 1.0)


def size_picture(state: AppState, zoom: float) -> None:
    """Screen pixels per picture pixel."""
    state.picture.zoom = zoom


def size_strip(state: AppState, count: int) -> None:
    """Small pictures that fit into the frame strip."""
    state.timeline.strip_count = count


def size_view(state: AppState, width: int, height: int) -> None:
    """Pixels of the 3D view, whose drags are looked for anew; none while it is hidden."""
    state.scene.size, state.scene.dragged = (width, height), False


def drag_view(state: AppState) -> None:
    """A hand moves the 3D view in this frame."""
    state.scene.dragged = True


def see_tuning(state: AppState) -> None:
    """The tuning grid is on screen."""
    state.tuning.in_sight = True


def place_tiles(state: AppState, columns: int) -> None:
    """So many tiles of the tuning grid beside each other."""
    state.tuning.columns = columns


def list_runs(state: AppState) -> None:
    """The list of the clip's runs is on screen."""
    state.runs.is_listed = state.source.clip is not None


def see_run_measures(state: AppState) -> None:
    """The measures of the run that is shown are on screen."""
    state.runs.sees_measures = True


def unfold_omissions(state: AppState, unfolded: bool) -> None:
    """The list of what the next reconstruction leaves out."""
    state.runs.asks_for_omissions = unfolded
