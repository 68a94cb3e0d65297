"""Exports of the window: a record of what is open, made a step at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from app.exports.make import make
from app.exports.records import MeasuresTable, PanesPicture, PanesRecord, PanesVideo, SpanRecord, ViewVideo
from app.exports.sources import Opened
from app.files.atomic import filled
from app.files.provenance import stamp
from app.files.records import Source
from app.files.stepping import map_steps

SUFFIXES = {"panes": ".png", "panes video": ".mp4", "view video": ".mp4", "measures": ".csv"}
Panes = TypeVar("Panes", bound=PanesRecord)


@dataclass(frozen=True, eq=False)
class ExportRequest:
    """One export; a second wish for the same is another request."""

    folder: Path
    stem: str
    record: PanesPicture | PanesVideo | MeasuresTable | ViewVideo
    """Its clip without a digest, which takes longer than the window can wait."""
    sources: Opened

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
    record = request.record
    if isinstance(record, PanesRecord):
        record = sourced(record, request.sources)
    name = f"{request.stem}-{stamp()}{SUFFIXES[record.kind]}"
    with filled(request.folder) as staging:
        yield from map_steps(make(record, request.sources, staging / name), Step)
    yield Step(request.steps, request.folder / name)


def sourced(record: Panes, sources: Opened) -> Panes:
    """With the digest of the clip that its panes are of. Raises OSError or UserError: it is gone."""
    clip = sources.own if record.panes else None
    return record if clip is None else replace(record, source=Source.of(clip.path))
