"""How the two pictures are looked at and what they are measured on, as functions on the state."""

from __future__ import annotations

from dataclasses import replace

from app.enhancement.settable import Pixels, Scope
from app.gui.state.app_state import AppState
from app.gui.views.picture_view import Room


def dismiss_notices(state: AppState) -> None:
    """What is said of the open video has been read."""
    state.source.notices = ()


def zoom(
    state: AppState, factor: float, at: tuple[float, float], picture: tuple[int, int], pane: Room
) -> None:
    """Nearer for a factor above 1, around a place in the pane."""
    state.picture.view = state.picture.view.zoomed(factor, at, picture, pane)


def pan(state: AppState, by: tuple[float, float], picture: tuple[int, int], pane: Room) -> None:
    """Along with the hand."""
    state.picture.view = state.picture.view.panned(by, picture, pane)


def fit(state: AppState) -> None:
    """As a whole."""
    state.picture.view = state.picture.view.fitted()


def one_to_one(state: AppState, zoom: float) -> None:
    """One picture pixel a pixel of the screen, which `zoom` of a window's units are."""
    state.picture.view = state.picture.view.one_to_one(zoom)


def begin_mask(state: AppState, at: tuple[float, float]) -> None:
    """A drag that draws the mask starts here in the picture."""
    state.picture.mask_start = at


def set_wipe(state: AppState, wipe: float) -> None:
    """The line of the wipe, as a share of the pane's width."""
    state.comparing.chosen = state.comparing.chosen.wiped(wipe)


def center_wipe(state: AppState) -> None:
    state.comparing.chosen = replace(state.comparing.chosen, wipe=0.5)


def choose_scope(state: AppState, scope: Scope) -> None:
    """What the automatic values are taken from."""
    state.enhancement.scope = scope


def choose_pixels(state: AppState, pixels: Pixels) -> None:
    """What counts in the statistics."""
    state.enhancement.pixels = pixels
