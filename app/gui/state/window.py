"""What the window itself needs: its clock, what it says, what it wishes for. A part of the state."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Literal

from app.gui.state.palette import Palette
from app.gui.work.file_writing import WriteRequest
from app.gui.work.presets import KeepPresets

Closing = Literal["no", "asked", "agreed"]
"""Whether the window shall close although reconstructions are under way."""
LOG_LINES = 500


@dataclass(frozen=True)
class Banner:
    """What went wrong, in one sentence, until it is dismissed."""

    message: str
    can_stop: bool = False
    """It is of an opening that takes long, which can be given up."""


@dataclass(frozen=True)
class Toast:
    """Good news that goes away by itself."""

    message: str
    until: float
    """On the window's clock, seconds."""


@dataclass
class WindowFrame:
    """Actions change it; drawing reads it."""

    now: float = 0.0
    """The window's clock, seconds."""
    banner: Banner | None = None
    toast: Toast | None = None
    log: deque[str] = field(default_factory=lambda: deque(maxlen=LOG_LINES))
    help_open: bool = False
    palette: Palette = field(default_factory=Palette)
    closing: Closing = "no"
    wishes: tuple[WriteRequest | KeepPresets, ...] = ()
    """What is to be kept on disk, until the next frame hands it to the background work."""
