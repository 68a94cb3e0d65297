"""What is compared with what, and how: plain values, kept in the state and in sessions."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, Literal, get_args

from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from app.enhancement.methods import PAPER, VESSEL
from app.enhancement.settable import ENHANCED, ORIGINAL, RENDER, Mode, Share, Source
from app.files.legible import named

Side = Literal["left", "right"]
SIDES: Final[tuple[Side, ...]] = get_args(Side)
PaneName = Literal["left", "right", "3D view"]
PANES: Final[tuple[PaneName, ...]] = get_args(PaneName)
SOURCE_LABELS: Final = {
    ORIGINAL: "Original",
    ENHANCED: "Enhanced (current settings)",
    "A": "Stored settings A",
    "B": "Stored settings B",
    RENDER: "Render of the open run",
    PAPER: "Method: Paper, defaults",
    VESSEL: "Method: Vessel, defaults",
}


def label_of(source: str) -> str:
    """The source as the lists name it."""
    return SOURCE_LABELS.get(source, f"Method: {named(source)}")


@dataclass(frozen=True, config=ConfigDict(extra="ignore", allow_inf_nan=False))
class Comparison:
    """Two sources and the way in which they are set against each other."""

    mode: Mode = "side by side"
    left: Source = ORIGINAL
    right: Source = ENHANCED
    wipe: Share = 0.5
    """Where the line of the wipe stands, as a share of the pane's width."""
    flipped: bool = False
    """The one pane of mode "flip" shows the left source."""
    zebra: bool = False
    """Clipped pixels are striped."""

    def source(self, side: Side) -> str:
        return self.left if side == "left" else self.right

    def showing(self, side: Side, source: str) -> Comparison:
        """With another source on that side."""
        return replace(self, left=source) if side == "left" else replace(self, right=source)

    def renewed(self) -> Comparison:
        """Left the original, right the enhanced, compared as before."""
        return replace(self, left=ORIGINAL, right=ENHANCED)

    def wiped(self, wipe: float) -> Comparison:
        """With the line elsewhere, never out of reach."""
        return replace(self, wipe=min(max(wipe, 0.02), 0.98))
