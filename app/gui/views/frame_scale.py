"""Where the frames of a clip are along the slider of its time, and so in the strip above that."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

PADDING: Final = 2.0
"""Pixels that ImGui leaves between a slider's frame and its handle."""


@dataclass(frozen=True)
class FrameScale:
    """As ImGui places the handle of a slider over whole numbers, one a frame."""

    left: float
    width: float
    """Of the slider's frame, in pixels."""
    count: int
    """Of frames, at least 1."""
    least: float
    """Pixels that a handle has at least."""

    @property
    def handle(self) -> float:
        """Its width: as much as a frame's share, where that is enough."""
        room = self.width - 2 * PADDING
        return min(max(room / self.count, self.least), room)

    def middle(self, frame: int) -> float:
        """Of the handle at this frame."""
        return self._first + self._apart * frame

    def ends(self, first: int, last: int) -> tuple[float, float]:
        """Left and right of the frames from `first` to `last`, as the handle covers them."""
        return self.middle(first) - self.handle / 2, self.middle(last) + self.handle / 2

    def frame_at(self, x: float) -> int:
        """The one whose handle is nearest."""
        if self._apart <= 0:
            return 0
        return min(max(round((x - self._first) / self._apart), 0), self.count - 1)

    @property
    def _first(self) -> float:
        return self.left + PADDING + self.handle / 2

    @property
    def _apart(self) -> float:
        """From frame to frame."""
        return (self.width - 2 * PADDING - self.handle) / max(self.count - 1, 1)
