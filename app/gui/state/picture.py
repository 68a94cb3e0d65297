"""The two pictures, how they are looked at, and what is drawn over them. A part of the state."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.enhancement.frame_enhancer import Pictures
from app.gui.views.picture_view import PictureView
from app.gui.work.measuring import Measured
from app.gui.work.strip import LeftOut


@dataclass
class Picture:
    """Picture and clip actions change it; drawing reads it."""

    pictures: Pictures | None = None
    asked_at: float = 0.0
    """When the newest pictures were asked for, on the window's clock."""
    measured: Measured | None = None
    pointer: tuple[int, int] | None = None
    """Column and row of the picture under the pointer."""
    view: PictureView = field(default_factory=PictureView)
    zoom: float = 1.0
    """Screen pixels per picture pixel, as last laid out."""
    overlay: bool = False
    """Tools and what is masked are tinted in the pictures."""
    left_out: LeftOut | None = None
    mask_tool: str = ""
    """What the next drag over a picture draws: "text", "view" or nothing."""
    mask_start: tuple[float, float] | None = None
    """Where in the picture that drag began."""
