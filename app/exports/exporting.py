"""Exports of the window: a record of what is open, made a step at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from app.exports.make import make
from app.exports.records import MeasuresTable, PanesPicture, PanesRecord, PanesVideo, SpanRecord, ViewVideo
from app.exports.sources import Opened
from app.files.atomic import filled
from app.files.provenance import stamp, write_png
from app.files.records import Source
from app.files.stepping import map_steps
from renderer.clip import ByteImage

SUFFIXES = {"panes video": ".mp4", "view video": ".mp4", "measures": ".csv"}
"""Of all that is no picture."""


@dataclass(frozen=True, eq=False)
class ExportRequest:
    """One export; a second wish for the same is another request."""

    folder: Path
    stem: str
    record: PanesPicture | PanesVideo | MeasuresTable | ViewVideo
    """Its clip without a digest, which takes longer than the window can wait."""
    sources: Opened
    screen: ByteImage | None = None
    """(H, W, 3): the whole window as it was read, which nothing else makes; `record` says what was in it."""

    @property
    def steps(self) -> int:
        """How often it comes up for air."""
        if isinstance(self.record, ViewVideo):
            return len(self.record.moments)
        return len(self.record.frames) if isinstance(self.record, SpanRecord) else 1


@dataclass(frozen=True)
class Step:
    """How far an export has come."""

    done: int
    path: Path | None = None
    """What has been written, at the end."""


def export(request: ExportRequest) -> Iterator[Step]:
    """Raises OSError, UserError, ClipError or ImageError; what it had begun to write vanishes."""
    record, clip = request.record, request.sources.own
    if isinstance(record, PanesRecord) and record.panes and clip is not None:
        record = replace(record, source=Source.of(clip.path))
    name = f"{request.stem}-{stamp()}{SUFFIXES.get(record.kind, '.png')}"
    with filled(request.folder) as staging:
        if request.screen is not None:
            write_png(staging / name, request.screen, record.signed)
        else:
            yield from map_steps(make(record, request.sources, staging / name), Step)
    yield Step(request.steps, request.folder / name)
