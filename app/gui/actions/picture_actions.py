"""How images are looked at, as functions on what holds their view."""

from __future__ import annotations

from typing import Protocol

from app.gui.views.picture_view import PictureView, Room


class Seen(Protocol):
    """The panes' images, or a cell of the tuning grid beside its original."""

    view: PictureView


def zoom(seen: Seen, factor: float, at: tuple[float, float], picture: tuple[int, int], pane: Room) -> None:
    """Nearer for a factor above 1, around a place in the pane."""
    seen.view = seen.view.zoomed(factor, at, picture, pane)


def pan(seen: Seen, by: tuple[float, float], picture: tuple[int, int], pane: Room) -> None:
    """Along with the hand."""
    seen.view = seen.view.panned(by, picture, pane)


def fit(seen: Seen) -> None:
    """As a whole."""
    seen.view = seen.view.fitted()


def one_to_one(seen: Seen, zoom: float) -> None:
    """One pixel of the image a pixel of the screen, which `zoom` of a window's units are."""
    seen.view = seen.view.one_to_one(zoom)
