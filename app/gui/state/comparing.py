"""What the two panes set against each other. A part of the state."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.exports.comparison_images import Difference, Other
from app.gui.views.comparison import Comparison, Side


@dataclass
class Comparing:
    """Comparing changes it; drawing reads it."""

    chosen: Comparison = field(default_factory=Comparison)
    others: dict[Side, Other] = field(default_factory=dict)
    """The newest pictures of each side that are neither photo nor present setting."""
    difference: Difference | None = None
    waits: bool = False
    """A picture of `others` is being made."""
    wiped: float = 0.5
    """Where the line of the wipe stands in the picture, as a share of its width, as last laid out."""
