"""Exports of the window, by value, a step at a time: panes and 3D view as pictures, videos or measures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from app.exports.comparison_images import OtherMaker
from app.exports.measure_table import measured_rows, write_measures
from app.exports.page import Panel, sheet
from app.exports.shots import Panes
from app.exports.view_pages import Views, drawn_panel, steady, video_facts, view_pages
from app.files.atomic import filled, together
from app.files.image_series import timing_of
from app.files.provenance import provenance, source, write_png, write_sidecar
from app.files.stepping import map_steps
from app.files.timestamp import stamp
from app.files.timing import Timing
from app.files.video import write_frames
from app.scenes.cpu_rendering import ON_CPU
from app.scenes.view_request import view_facts
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
        if request.form == "picture":
            _picture(request, staging / name)
        elif request.form == "measures":
            yield from _measures(request, staging / name)
        else:
            yield from _video(request, staging / name)
    yield Step(request.steps, request.folder / name)


def _facts(request: ExportRequest) -> dict[str, Any]:
    """Of all panes: their clip, and how they are laid out."""
    panes = request.panes
    facts = {"source": source(panes.shots[0].photo.clip.path), "clip_options": request.clip_options}
    facts |= {"scale": panes.sizing.scale, "width": panes.sizing.width, "arrangement": panes.arrangement}
    return facts | {"panes": [shot.facts for shot in panes.shots]}


def _span_facts(request: ExportRequest) -> dict[str, int]:
    return {"first_frame": request.span[0], "last_frame": request.span[1]}


def picture_facts(request: ExportRequest) -> dict[str, Any]:
    """What there is to see: the panes' clip and frame, and the 3D view."""
    facts: dict[str, Any] = {}
    if request.panes.shots:
        photo = request.panes.shots[0].photo
        frame = {"index": photo.frame_index, "label": photo.clip.labels[photo.frame_index]}
        facts = _facts(request) | {"frame": frame}
    for views in request.moments:
        facts["views"] = [view_facts(wanted, ON_CPU) for wanted in views]
    return facts


def _picture(request: ExportRequest, path: Path) -> None:
    panels: list[Panel] = []
    facts = picture_facts(request)
    if request.panes.shots:
        made = request.panes.made(OtherMaker())
        panels += request.panes.laid_out(made)
        for said, one in zip(facts["panes"], made, strict=True):
            said["statistics"] = one.statistics
    for views in request.moments:
        panels += [drawn_panel(wanted) for wanted in views]
    write_png(path, sheet(panels), provenance(kind="panes", **facts))


def _video(request: ExportRequest, path: Path) -> Iterator[Step]:
    timing = Timing(request.frames_per_second)
    if request.form == "view video":
        moments = yield from map_steps(steady(request.moments), Step)
        frames, facts = view_pages(moments), {"kind": "view video"} | video_facts(moments)
    else:
        request = replace(request, panes=request.panes.steady(OtherMaker()))
        frames = request.panes.pages(request.frames)
        facts = {"kind": "panes video"} | _facts(request) | _span_facts(request)
        kept = timing_of(request.panes.shots[0].photo.clip, request.frames)
        timing = replace(kept, frames_per_second=request.frames_per_second)
    with together(path) as place:
        written = yield from map_steps(write_frames(place, frames, timing), Step)
        facts |= {"frames_per_second": request.frames_per_second, "video": written}
        write_sidecar(place, provenance(**facts))


def _measures(request: ExportRequest, path: Path) -> Iterator[Step]:
    rows = []
    for done, rows_of_frame in enumerate(measured_rows(request.panes, request.frames), start=1):
        rows += rows_of_frame
        yield Step(done)
    write_measures(path, rows, _facts(request) | _span_facts(request))
