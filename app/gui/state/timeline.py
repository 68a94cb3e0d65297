"""Where the open clip stands and whether it plays, with its frame strip. A part of the state."""

from __future__ import annotations

from dataclasses import dataclass

from app.gui.work.strip import Strip


@dataclass
class Timeline:
    """Time's actions change it; drawing reads it."""

    frame_index: int = 0
    frozen_index: int | None = None
    """The frame that the pictures hold while the clip's time goes on."""
    playing: bool = False
    playhead: float = 0.0
    """Position in frames while playing; frame_index is its whole part."""
    strip: Strip | None = None
    strip_count: int = 0
    """Small pictures that fit into the frame strip, as last laid out."""

    @property
    def shown_index(self) -> int:
        """Frame of the two pictures."""
        return self.frame_index if self.frozen_index is None else self.frozen_index
