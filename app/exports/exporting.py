"""Exports of the window: a record of what is open becomes a file, a step at a time."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, count
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from app.console.flags import problem
from app.enhancement.enhance_files import Setting, enhance_frame_into, enhance_into
from app.errors import UserError
from app.exports.camera_set import CameraSet, form_of, write_cameras
from app.exports.make import make
from app.exports.records import (
    CaseSummary,
    Export,
    ModelArrays,
    MovingSplats,
    PanesPicture,
    PanesRecord,
    SpanRecord,
    Splats,
    SummaryPicture,
    SurfaceMesh,
    Tracks,
    ViewVideo,
)
from app.exports.sources import Opened
from app.files.atomic import filled, require_there
from app.files.image_files import write_image
from app.files.image_series import Series, open_series
from app.files.provenance import provenance, write_png
from app.files.records import Source
from app.files.stepping import map_steps, run_to_end
from app.live.picture import FRAME, LIVE
from renderer.clip import ByteImage, Clip


@dataclass(frozen=True)
class MomentFiles:
    """A folder with a model or its surface at several moments, a file each."""

    files: tuple[tuple[str, Splats | SurfaceMesh], ...]
    """By name."""


UNTITLED: Final = "Case summary"


@dataclass(frozen=True)
class Summary:
    """Saved pictures on a page to print. What is typed here becomes what the file says."""

    title: str
    day: str
    notes: str
    pictures: tuple[tuple[Path, str], ...]
    """Each with a note."""

    @property
    def files(self) -> tuple[Path, ...]:
        return tuple(path for path, _ in self.pictures)

    def record(self) -> CaseSummary:
        """Reads each file for its digest. Raises OSError; UserError: a text is too long."""
        try:
            told = tuple(SummaryPicture(picture=Source.of(path), note=note) for path, note in self.pictures)
            return CaseSummary(
                title=self.title,
                day=self.day,
                notes=self.notes,
                pictures=told,
                measures_of="all images",
                layout="fitted",
            )
        except ValidationError as error:
            raise UserError(problem(error)) from error


@dataclass(frozen=True)
class Enhanced:
    """What is open, enhanced as a DICOM object: one frame as a still, or all of a clip as a video."""

    path: Path
    setting: Setting
    frame: int | None
    label: str
    """Of that frame."""
    count: int
    """Frames that there are."""

    def written(self, target: Path) -> Iterator[int]:
        """Frames done. Raises UserError or ClipError."""
        series = open_series(self.path, self.setting.clip_options)
        if self.frame is None:
            yield from enhance_into(target, series, self.setting)
        else:
            made = enhance_frame_into(target, series, self._place(series), self.setting)
            yield from map_steps(made, lambda measured: 0)

    def _place(self, series: Series) -> int:
        """Of the frame in the series, which has all images of a folder; a clip may keep one in several."""
        assert self.frame is not None
        names = () if series.is_video else series.names
        found = (names.index(name) for name in (self.label, Path(self.label).stem) if name in names)
        return next(found, self.frame)


Exported = Export | MomentFiles | Summary | CameraSet | Enhanced
"""The record of a file, or what becomes one, or several, as it is written."""


@dataclass(frozen=True, eq=False)
class ExportRequest:
    """One export; a second wish for the same is another request."""

    folder: Path
    stem: str
    """Of the name; where that is taken, a number follows it, and what is there stays."""
    suffix: str
    """Which says the format; empty for a folder."""
    record: Exported
    """Its clip without a digest, which takes longer than the window can wait."""
    sources: Opened = Opened()  # noqa: RUF009
    screen: ByteImage | None = None
    """(H, W, 3): the whole window as it was read, which nothing else makes; `record` says what was in it."""

    @property
    def steps(self) -> int:
        """How often it comes up for air."""
        if isinstance(self.record, ViewVideo | ModelArrays | Tracks):
            return len(self.record.moments)
        if isinstance(self.record, Enhanced):
            return self.record.count if self.record.frame is None else 1
        if isinstance(self.record, MomentFiles):
            return len(self.record.files)
        if isinstance(self.record, SurfaceMesh | MovingSplats) and self.sources.model is not None:
            return len(self.sources.model.cameras)
        return len(self.record.frames) if isinstance(self.record, SpanRecord) else 1


@dataclass(frozen=True)
class Step:
    """How far an export has come."""

    done: int
    path: Path | None = None
    """What has been written, at the end."""


def export(request: ExportRequest) -> Iterator[Step]:
    """Raises OSError, UserError, ClipError or ImageError; what it had begun to write vanishes."""
    if not request.suffix:
        path = request.folder / free_name(request.folder, request.stem)
        yield from _made(request, path)
    else:
        # Where the disk is full, that is told of the name that the file would have had.
        name = free_name(request.folder, request.stem, request.suffix)
        with filled(request.folder) as staging:
            yield from map_steps(_made(request, staging / name), partial(_while_there, staging))
            path = request.folder / _renamed(staging, request, name)
    yield Step(request.steps, path)


def _while_there(folder: Path, step: Step) -> Step:
    """Raises UserError: the folder is gone, which would be seen only at the end."""
    require_there(folder)
    return step


def _made(request: ExportRequest, target: Path) -> Generator[Step, None, None]:
    """The file at `target`, or the folder: whole or not at all."""
    record, clip = request.record, request.sources.own
    if isinstance(record, CameraSet):
        write_cameras(target, record, form_of(request.suffix))
        return
    if isinstance(record, Enhanced):
        yield from map(Step, record.written(target))
        return
    if isinstance(record, MomentFiles):
        with filled(target) as staging:
            for done, (name, one) in enumerate(record.files, start=1):
                run_to_end(make(one, request.sources, staging / name))
                yield Step(done)
        return
    if isinstance(record, Summary):
        record = record.record()
    elif isinstance(record, PanesRecord) and record.panes and clip is not None:
        record = replace(record, source=_source(_kept(clip, request.folder)))
    if request.screen is not None and isinstance(record, PanesPicture):
        write_image(target, request.screen, record.signed, record.quality)
    else:
        yield from map_steps(make(record, request.sources, target), Step)


def _source(path: Path) -> Source:
    """Raises UserError: it was moved away, or its disk was unplugged, since it was opened."""
    try:
        return Source.of(path)
    except FileNotFoundError as error:
        wanted = "expected the clip where it was opened"
        raise UserError(f"{wanted}, got no such file or folder: {path}") from error


def _kept(clip: Clip, folder: Path) -> Path:
    """Where the clip lies. A frame of a live source is nowhere yet: it is kept beside what is made of it."""
    if clip.format != LIVE:
        return clip.path
    path = folder / clip.path.name
    if not path.exists():
        write_png(path, clip.read_image(0), provenance(kind=FRAME))
    return path


def _renamed(staging: Path, request: ExportRequest, name: str) -> str:
    """What was made by this name, and lies beside it, by the name that is free now: another export may have
    ended meanwhile."""
    made = [item.name for item in staging.iterdir()]
    free = free_name(
        request.folder, request.stem, request.suffix, beside=[item[len(name) :] for item in made]
    )
    for item in made if free != name else ():
        (staging / item).rename(staging / (free + item[len(name) :]))
    return free


def free_name(folder: Path, stem: str, suffix: str = "", beside: list[str] | None = None) -> str:
    """The name, or with the first number from 2 on by which nothing is there, nor `beside` with more behind
    its suffix."""
    tried = chain((f"{stem}{suffix}",), (f"{stem}-{number}{suffix}" for number in count(2)))
    ends = ("", *(beside or ()))
    return next(name for name in tried if not any(os.path.lexists(folder / (name + end)) for end in ends))
