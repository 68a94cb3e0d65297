"""Where the 3D view is seen from, and what the hand does there. A part of the state: plain values."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.gui.views.measurement import Measurement
from app.gui.work.picking import PickRequest
from app.scenes.free_camera import FreeView, Vector
from app.scenes.photos import Photo

MIN_SPEED, MAX_SPEED = 0.02, 4.0


@dataclass
class Viewer:
    """Camera actions change it; drawing reads it."""

    free: FreeView | None = None
    """None: the clip's own camera, at every time."""
    snapped: bool = False
    """The clip's camera with its own pixels, under its photo."""
    blend: float = 0.5
    """Share of the photo in a snapped view, in [0, 1]."""
    photo: Photo | None = None
    """The newest photo for a snapped view."""
    pivot: Vector | None = None
    """What the view turns around; None: the middle of the tissue, until the view leaves the clip's camera."""
    flying: bool = False
    speed: float = 0.3
    """Of flight: the scene's distance so many times a second."""
    moving: bool = False
    """A key of flight is held."""
    measuring: bool = False
    """A click on the view picks a point of a distance."""
    measurement: Measurement = field(default_factory=Measurement)
    pick: PickRequest | None = None
    """The newest wish for a point on the surface."""
