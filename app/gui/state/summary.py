"""The case summary: saved pictures with notes, on their way to a page. A part of the state."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from app.exports.exporting import ExportRequest
from renderer.clip import ByteImage


@dataclass(frozen=True)
class Item:
    """A picture, by its file."""

    path: Path
    note: str = ""


@dataclass
class CaseSummary:
    """What goes on the page. Summary actions change it; drawing reads it."""

    shown: bool = False
    """Its panel."""
    title: str = ""
    notes: str = ""
    items: tuple[Item, ...] = ()
    """In the order of the page."""
    awaited: tuple[ExportRequest, ...] = ()
    """Pictures that are being saved for it."""
    thumbnails: dict[Path, ByteImage | None] = field(default_factory=dict)
    """Of its files; None: it cannot be read."""
