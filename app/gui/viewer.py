"""Where the 3D view is seen from, and what the hand does there. A part of the state: plain values."""

from __future__ import annotations

from dataclasses import dataclass

from app.gui.free_view import FreeView, Vector
from app.gui.picking import PickRequest

MIN_SPEED, MAX_SPEED = 0.02, 4.0


@dataclass
class Viewer:
    """Camera actions change it; drawing reads it."""

    free: FreeView | None = None
    """None: the clip's own camera, at every time."""
    pivot: Vector | None = None
    """What the view turns around; None: the middle of the tissue, until the view leaves the clip's camera."""
    flying: bool = False
    speed: float = 0.3
    """Of flight: the scene's distance so many times a second."""
    moving: bool = False
    """A key of flight is held."""
    pick: PickRequest | None = None
    """The newest wish for a point on the surface."""
