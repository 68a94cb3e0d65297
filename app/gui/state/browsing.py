"""The file dialog inside the window: where it is, what is listed, typed and marked. A part of the state."""

from __future__ import annotations

import re
from collections import OrderedDict
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Literal

from app.files.legible import legible
from app.gui.state.choosing import Choosing
from app.gui.work.listing import Entry, Listing, ListRequest
from renderer.clip import ByteImage

Column = Literal["name", "date", "size"]
MOST_THUMBNAILS: Final = 200


def _by_name(name: str) -> list[tuple[bool, int, str]]:
    """As file managers sort: numbers before letters, 2 before 10, capitals or not."""
    parts = re.findall(r"\d+|\D+", name.casefold())
    return [(False, int(part), "") if part.isdecimal() else (True, 0, part) for part in parts]


@dataclass
class Browsing:
    """Browse actions change it; drawing reads it."""

    choosing: Choosing
    folder: Path
    text: str = ""
    """In the line of the path."""
    typed: bool = False
    """By hand, since a folder was entered or an entry marked."""
    name: str = ""
    """Of a file to be written."""
    marked: Path | None = None
    """The entry that the list stands on."""
    came_from: Path | None = None
    """The folder that was left for the one above it, to be marked there."""
    listing: Listing | None = None
    """Of `folder`; None while it is read."""
    filter: int = 0
    """Which of the question's is in force."""
    column: Column = "name"
    descending: bool = False
    in_sight: tuple[Path, ...] = ()
    """Entries on screen as last laid out, which are to have thumbnails."""
    thumbnails: OrderedDict[Path, ByteImage | None] = field(default_factory=OrderedDict)
    """Newest last; None: there is nothing to see."""
    focus: bool = True
    """The line is to be typed into from the next frame on, with what is in it selected."""
    line: int = 0
    """Another one each time that something else than typing has filled it in: a line that is typed into keeps
    its own text."""
    scroll: bool = False
    """The marked entry is to come into sight."""
    looked: tuple[object, Entry] | None = None
    """What was looked up last, and for what."""
    _shown: tuple[object, tuple[Entry, ...]] | None = None

    @property
    def request(self) -> ListRequest:
        """What is to be listed."""
        return ListRequest(self.folder, self.choosing.kind == "save" and self.folder == self.choosing.start)

    @property
    def entries(self) -> tuple[Entry, ...]:
        """Those that can be entered or chosen, as sorted: folders first. Of a name that is typed, those that
        begin with it, where any do."""
        # The listing itself: another may lie where one that is gone has lain.
        key = (self.listing, self.filter, self.column, self.descending, self.begun)
        if self._shown is None or self._shown[0] != key:
            self._shown = key, self._sorted()
        return self._shown[1]

    @property
    def begun(self) -> str:
        """What is typed of a name in this folder, folded; empty for nothing."""
        path = self.folder / self.text
        is_name = self.typed and self.choosing.kind != "save" and path.parent == self.folder
        return path.name.casefold() if is_name else ""

    def _sorted(self) -> tuple[Entry, ...]:
        found = self.listing.entries if self.listing is not None else ()
        filters, folders_alone = self.choosing.question.filters, self.choosing.kind == "folder"
        passes = filters[self.filter].passes if filters else lambda path: True
        kept = [
            entry for entry in found if entry.kind == "folder" or (not folders_alone and passes(entry.path))
        ]
        kept = [entry for entry in kept if entry.name.casefold().startswith(self.begun)] or kept
        # Sorting is stable: what is equal stays by name.
        kept.sort(key=lambda entry: _by_name(entry.name))
        if self.column == "date":
            kept.sort(key=lambda entry: entry.modified)
        elif self.column == "size":
            kept.sort(key=lambda entry: entry.size)
        if self.descending:
            kept.reverse()
        return tuple(sorted(kept, key=lambda entry: entry.kind != "folder"))

    def mark(self, path: Path | None) -> None:
        """The line says it, too; a file's name is the one to be written."""
        self.marked, self.text, self.typed = path, legible(str(path or self.folder)), False
        self.focus = self.scroll = True
        self.line += 1
