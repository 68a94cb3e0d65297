"""What the window itself needs: its clock, what it says, what it wishes for. A part of the state."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from app.exports.exporting import ExportRequest
from app.gui.state.browsing import Browsing
from app.gui.state.choosing import Choosing
from app.gui.work.changing_runs import ChangeRequest
from app.gui.work.keeping import KeepClip, KeepSettings
from app.gui.work.masking import KeepMask
from app.gui.work.presets import KeepPresets
from app.gui.work.revealing import RevealRequest
from app.gui.work.writing import SessionRequest, WriteRequest
from app.kernels.progress import Preparation

Closing = Literal["no", "asked", "agreed"]
"""Whether the window shall close although reconstructions are under way."""
LOG_LINES = 500
Wish = (
    WriteRequest
    | KeepSettings
    | KeepClip
    | KeepPresets
    | SessionRequest
    | ExportRequest
    | RevealRequest
    | ChangeRequest
    | KeepMask
)


@dataclass
class Palette:
    """Whether it is shown, the words typed, and which found command is marked."""

    shown: bool = False
    words: str = ""
    marked: int = 0

    def open(self) -> None:
        self.shown, self.words, self.marked = True, "", 0

    def stay(self, shown: bool) -> None:
        """Open, or closed from now on."""
        self.shown = shown

    def type(self, words: str) -> None:
        """Other words find other commands: the first of them is marked."""
        if words != self.words:
            self.words, self.marked = words, 0

    def move(self, by: int, count: int) -> None:
        """Up or down in a list of `count`, from its end to its start and back."""
        self.marked = (self.marked + by) % max(count, 1)


@dataclass(frozen=True)
class Banner:
    """What went wrong, in one sentence, until it is dismissed."""

    message: str
    can_stop: bool = False
    """It is of an opening that takes long, which can be given up."""
    find: Callable[[], None] | None = None
    """It is of something lost: lets a person say where it lies."""


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
    bare: bool = False
    """The panels are hidden: the pictures alone."""
    full_screen: bool = False
    layout_changes: int = 0
    """How often another kind of content has brought its own layout."""
    palette: Palette = field(default_factory=Palette)
    closing: Closing = "no"
    choosing: Choosing | None = None
    """Until the next frame asks for it."""
    browsing: Browsing | None = None
    """The file dialog inside the window."""
    folders: Mapping[str, Path] = field(default_factory=dict)
    """Where a person was for each purpose of a dialog, in this session."""
    preparation: Preparation | None = None
    """The one-time preparation that is under way."""
    wishes: tuple[Wish, ...] = ()
    """What is to be written, until the next frame hands it to the background work."""
