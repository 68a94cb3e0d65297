"""What is exported and how large, as chosen. A part of the state."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.gui.work.exporting import Exporting
from app.gui.work.sizing import Sizing


@dataclass
class Exports:
    """Export actions change it; drawing reads it."""

    shown: bool = False
    """Its panel."""
    sizing: Sizing = field(default_factory=Sizing)
    """Of the panes."""
    view_size: tuple[int, int] | None = None
    """Pixels of the 3D view in files; None: its shape on screen, no smaller than the clip's photos."""
    under_way: Exporting | None = None
