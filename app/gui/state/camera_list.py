"""Named views and the camera path of what is open. A part of the state: plain values."""

from __future__ import annotations

from dataclasses import dataclass, field

from renderer.view_files import Views


@dataclass
class CameraList:
    """View actions change it; drawing reads it."""

    views: Views = field(default_factory=Views)
    playing: bool = False
    """The path moves the 3D view."""
    playhead: float = 0.0
    """Seconds on the path."""
    path_shown: bool = True
    """The path is drawn in the 3D view."""
    name: str = ""
    """Typed for the next named view."""
