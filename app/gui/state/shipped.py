"""The first page, the guide, and what the program says of itself. Parts of the state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from app.gui.work.about import About
from app.gui.work.recents import Recent
from app.gui.work.shipped import Guide
from renderer.clip import ByteImage


@dataclass
class Welcome:
    """Answers change it; drawing reads it."""

    recents: Mapping[str, Recent] = field(default_factory=dict)
    """What was opened lately, by path, as far as it has been looked at."""
    samples: Mapping[str, ByteImage] = field(default_factory=dict)
    """Images of what the program does, by name."""


@dataclass
class ShownGuide:
    """Guide actions change it; drawing reads it."""

    shown: bool = False
    page: int = 0
    pages: Guide | None = None
    """None until they have been read."""


@dataclass
class ShownAbout:
    """About actions change it; drawing reads it."""

    shown: bool = False
    facts: About | None = None
    """None until they are known."""
