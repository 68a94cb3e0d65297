"""One pane alone over the whole window, and one in a window of its own. A part of the state."""

from __future__ import annotations

from dataclasses import dataclass

from app.gui.views.comparison import PaneName


@dataclass
class Presenting:
    """Presenting actions change it; drawing reads it."""

    pane: PaneName | None = None
    """Alone over the whole window; None: all panels are there."""
    ending: PaneName | None = None
    """Left, but still drawn: the panels that come back are there one frame later."""
    labels: bool = False
    """What it is stands over it, as long as one wants."""
    labels_until: float = 0.0
    """On the window's clock: up to then it stands there anyway."""
    was_full_screen: bool = False
    """Before the presentation, which fills the screen."""
    under: PaneName | None = None
    """The pane under the pointer in this frame."""
    clicked: PaneName = "right"
    """The one that was clicked last."""
    in_sight: tuple[PaneName, ...] = ()
    """Those that are drawn in this frame, not behind another panel."""


@dataclass
class SecondWindow:
    """For a second monitor: it follows the first window, which keeps the controls."""

    shown: bool = False
    pane: PaneName = "right"
    labels: bool = True
    full_screen: bool = False
    place: tuple[int, int, int, int] | None = None
    """Left, top, width and height, as last seen when it did not fill a screen."""
