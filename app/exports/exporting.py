"""Exports of the window, by value, a step at a time: panes and 3D view as images, videos or measures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from app.exports.make import make
from app.exports.records import (
    FrameRecord,
    MeasuresTable,
    PanesPicture,
    PanesRecord,
    PanesVideo,
    ViewVideo,
)
from app.exports.shots import Panes
from app.exports.sources import Opened
from app.exports.view_pages import Views
from app.files.atomic import filled
from app.files.records import Source, extended
from app.files.stepping import map_steps
from app.files.timestamp import stamp
from app.scenes.cpu_rendering import ON_CPU
from app.scenes.scene import Scene
from app.scenes.view_request import drawn_record, moment_record, view_record
from app.scenes.view_selection import FRAMES_PER_SECOND
from renderer.readers.clip_options import DEFAULTS, ClipOptions

Form = Literal["picture", "panes video", "view video", "measures"]
SUFFIXES: dict[Form, str] = {
    "picture": ".png", "panes video": ".mp4", "view video": ".mp4", "measures": ".csv",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class ExportRequest:
    """One export; a second wish for the same is another request."""

    folder: Path
    stem: str
    form: Form
    panes: Panes = field(default_factory=Panes)
    moments: tuple[Views, ...] = ()
    """Of the 3D view, with as many pixels as the file has: one in a picture, in a video one a frame."""
    span: tuple[int, int] = (0, 0)
    """First and last frame of the clip that a video or a table of panes has."""
    frames_per_second: float = FRAMES_PER_SECOND
    clip_options: ClipOptions = DEFAULTS

    @property
    def steps(self) -> int:
        """How often it comes up for air."""
        if self.form == "picture":
            return 1
        return len(self.moments) if self.form == "view video" else len(self.frames)

    @property
    def frames(self) -> range:
        """Of the clip, in a video or a table of panes."""
        return range(self.span[0], self.span[1] + 1)


@dataclass(frozen=True)
class Step:
    """How far an export has come."""

    done: int
    path: Path | None = None
    """What has been written, at the end."""


def export(request: ExportRequest) -> Iterator[Step]:
    """Raises OSError, UserError, ClipError or ImageError; what it had begun to write vanishes."""
    name = f"{request.stem}-{stamp()}{SUFFIXES[request.form]}"
    with filled(request.folder) as staging:
        yield from map_steps(make(record_of(request), opened(request), staging / name), Step)
    yield Step(request.steps, request.folder / name)


def opened(request: ExportRequest) -> Opened:
    """What it is made of, as it is open."""
    shots = request.panes.shots
    return Opened(
        tuple(view for views in request.moments for view in views),
        shots[0].photo.clip if shots else None,
        tuple(shot.by for shot in shots if isinstance(shot.by, Scene)),
    )


def record_of(request: ExportRequest) -> PanesPicture | PanesVideo | MeasuresTable | ViewVideo:
    """Raises OSError or UserError: the clip is gone."""
    rate, moments = request.frames_per_second, request.moments
    if request.form == "picture":
        return picture_record(request)
    if request.form == "view video":
        return ViewVideo(
            views=tuple(drawn_record(view, ON_CPU) for view in moments[0]),
            moments=tuple(moment_record(views[0]) for views in moments),
            frames_per_second=rate,
        )
    first, last = request.span
    if request.form == "measures":
        return extended(MeasuresTable, _panes_record(request), first_frame=first, last_frame=last)
    return extended(
        PanesVideo, _panes_record(request), first_frame=first, last_frame=last, frames_per_second=rate
    )


def picture_record(request: ExportRequest) -> PanesPicture:
    """What there is to see: the panes' clip and frame, and the 3D view."""
    panes = _panes_record(request) if request.panes.shots else PanesRecord()
    views = tuple(view_record(view, ON_CPU) for views in request.moments for view in views)
    return extended(PanesPicture, panes, views=views)


def _panes_record(request: ExportRequest) -> PanesRecord:
    """Of all panes: their clip, and how they are laid out."""
    panes, photo = request.panes, request.panes.shots[0].photo
    return PanesRecord(
        source=Source.of(photo.clip.path),
        clip_options=request.clip_options,
        frame=FrameRecord(index=photo.frame_index, label=photo.clip.labels[photo.frame_index]),
        scale=panes.sizing.scale,
        width=panes.sizing.width,
        arrangement=panes.arrangement,
        panes=tuple(shot.record for shot in panes.shots),
    )
