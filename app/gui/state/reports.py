"""The report that is shown. A part of the state."""

from __future__ import annotations

from dataclasses import dataclass

from app.gui.work.reported import Reported


@dataclass
class Reports:
    """Actions change it; drawing reads it."""

    shown: Reported | None = None
    place: int = 0
    """Which diagram of it is shown."""
    asked: bool = False
    """Its panel is to come to the front."""
