"""The two pictures: what they are compared with, how they are looked at, what is drawn over them. A part of
the state."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.enhancement.clip_statistics import ClipStatistics
from app.enhancement.frame_enhancer import PictureRequest, Pictures
from app.exports.comparison_images import Difference, Other
from app.gui.views.comparison import Comparison, Side
from app.gui.views.picture_view import PictureView
from app.gui.work.masking import LeftOut
from app.gui.work.measuring import Measured


@dataclass
class Comparing:
    """What the two panes set against each other. Comparing changes it; drawing reads it."""

    chosen: Comparison = field(default_factory=Comparison)
    others: dict[Side, Other] = field(default_factory=dict)
    """The newest pictures of each side that are neither frame nor present setting."""
    difference: Difference | None = None
    waits: bool = False
    """A picture of `others` is being made."""
    wiped: float = 0.5
    """Where the line of the wipe stands in the picture, as a share of its width, as last laid out."""


@dataclass
class Picture:
    """Picture and clip actions change it; drawing reads it."""

    pictures: Pictures | None = None
    failed: PictureRequest | None = None
    """The last one that was without an answer."""
    asked_at: float = 0.0
    """When the newest pictures were asked for, on the window's clock."""
    of_clip: ClipStatistics | None = None
    """What all frames of a clip are enhanced with; it knows of which."""
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
