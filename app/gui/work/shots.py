"""Exports of the window, by value, a step at a time: panes as picture, video or measures; the 3D view."""

from __future__ import annotations

import csv
import io
from collections.abc import Generator, Iterator
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

import numpy as np

from app.atomic import write_bytes
from app.gui.work.enhancing import PictureRequest
from app.gui.work.export import Panel, describe, sheet, view_facts
from app.gui.work.others import OtherMaker, OtherRequest
from app.gui.work.viewing import ShownModel, ViewRequest, draw_view
from app.methods import Look
from app.moments import FRAMES_PER_SECOND
from app.provenance import provenance, source, strict_json, write_png, write_sidecar
from app.tuning import DEFINITIONS, METRICS, measured
from app.video import Written, write_frames
from enhance import Statistics
from enhance.vesselness import field_of_view, vessel_mask
from renderer.clip import ByteImage
from renderer.readers.clip_options import DEFAULTS, ClipOptions

Form = Literal["panes", "panes video", "measures", "view video"]


@dataclass(frozen=True)
class Shot:
    """What one pane shows, at any frame."""

    title: str
    photo: PictureRequest
    """The frame, and how statistics are taken; its own params do not matter."""
    by: Look | str | ShownModel | None = None
    """A setting, a method without parameters, or a model; None: the photo."""

    def at(self, frame: int) -> Shot:
        return replace(self, photo=replace(self.photo, frame_index=frame))

    @property
    def facts(self) -> dict[str, Any]:
        """Enough to make it again, beside the clip and the frame."""
        photo, by = self.photo, self.by
        facts: dict[str, Any] = {"title": self.title, "scope": photo.scope, "tissue_only": photo.tissue_only}
        if isinstance(by, ShownModel):
            return facts | {"shows": "render", "view": view_facts(by.of_frame(photo.frame_index))}
        if isinstance(by, str):
            return facts | {"shows": "method", "method": by}
        return facts | ({"shows": "original"} if by is None else {"shows": "setting", "params": by})


@dataclass(frozen=True, eq=False)
class ExportRequest:
    """One export; a second wish for the same is another request."""

    folder: Path
    stem: str
    form: Form
    shots: tuple[Shot, ...] = ()
    view: ViewRequest | None = None
    """Of a video of the 3D view: where it is seen from, with as many pixels as are drawn."""
    scale: int = 1
    """Pixels of the file a pixel of the picture, each way."""
    frames_per_second: float = FRAMES_PER_SECOND
    clip_options: ClipOptions = DEFAULTS

    @property
    def steps(self) -> int:
        """How often it comes up for air."""
        if self.form == "view video" and self.view is not None:
            return len(self.view.shown.cameras)
        return len(self.shots[0].photo.clip) if self.form != "panes" else 1


@dataclass(frozen=True)
class Step:
    """How far an export has come."""

    done: int
    path: Path | None = None
    """What has been written, at the end."""


@dataclass
class Exporting:
    """The export that is under way, for the state."""

    request: ExportRequest
    done: int = 0


def export(request: ExportRequest) -> Iterator[Step]:
    """Raises OSError, UserError, ClipError or ImageError; what it had begun to write vanishes."""
    stamp = datetime.now().astimezone().strftime("%Y%m%d-%H%M%S-%f")[:-3]
    place = request.folder / f"{request.stem}-{stamp}"
    if request.form == "panes":
        yield from _picture(request, place.with_name(f"{place.name}.png"))
    elif request.form == "measures":
        yield from _measures(request, place.with_name(f"{place.name}.csv"))
    else:
        yield from _video(request, place.with_name(f"{place.name}.mp4"))


def panel(shot: Shot, maker: OtherMaker, scale: int) -> tuple[Panel, Statistics | None]:
    """The picture at the size of the file, with what stands above it, and what it was made with.

    A pixel of the picture is a square of the file: no value is made up between two.
    """
    photo = shot.photo
    label = photo.clip.labels[photo.frame_index]
    if shot.by is None:
        return Panel(
            f"{shot.title}   {label}", _enlarged(photo.clip.read_image(photo.frame_index), scale)
        ), None
    (other,) = maker.make(OtherRequest(replace(photo, params=None), shot.by))
    said = describe(other.made) if other.made is not None else ""
    used = other.made.statistics if other.made is not None else None
    return Panel(f"{shot.title}   {said}".rstrip(), _enlarged(other.image, scale)), used


def _enlarged(image: ByteImage, scale: int) -> ByteImage:
    return image if scale == 1 else np.ascontiguousarray(image.repeat(scale, axis=0).repeat(scale, axis=1))


def _facts(request: ExportRequest) -> dict[str, Any]:
    """Of all panes: their clip."""
    clip = request.shots[0].photo.clip
    return {"source": source(clip.path), "clip_options": request.clip_options, "scale": request.scale}


def _picture(request: ExportRequest, path: Path) -> Iterator[Step]:
    maker = OtherMaker()
    made = [panel(shot, maker, request.scale) for shot in request.shots]
    panes = [shot.facts | {"statistics": used} for shot, (_, used) in zip(request.shots, made, strict=True)]
    frame = request.shots[0].photo.frame_index
    facts = provenance(kind="panes", **_facts(request), frame={"index": frame}, panes=panes)
    write_png(path, sheet([one for one, _ in made]), facts)
    yield Step(1, path)


def _video(request: ExportRequest, path: Path) -> Iterator[Step]:
    frames = _view_frames(request.view) if request.view is not None else _pane_frames(request)
    written = yield from _counted(write_frames(path, frames, request.frames_per_second))
    facts = _view_video_facts(request.view) if request.view is not None else _pane_video_facts(request)
    facts |= {"frames_per_second": request.frames_per_second, "video": written}
    write_sidecar(path, provenance(**facts))
    yield Step(request.steps, path)


def _counted(writing: Generator[int, None, Written]) -> Generator[Step, None, Written]:
    try:
        while True:
            try:
                yield Step(next(writing))
            except StopIteration as end:
                written: Written = end.value
                return written
    finally:
        writing.close()


def _pane_frames(request: ExportRequest) -> Iterator[ByteImage]:
    maker = OtherMaker()
    for frame in range(request.steps):
        yield sheet([panel(shot.at(frame), maker, request.scale)[0] for shot in request.shots])


def _pane_video_facts(request: ExportRequest) -> dict[str, Any]:
    panes = [shot.facts for shot in request.shots]
    return {"kind": "panes video"} | _facts(request) | {"frames": request.steps, "panes": panes}


def _view_moments(view: ViewRequest) -> list[ViewRequest]:
    """The same view at every frame's time; through the clip's camera where it is not a free one."""
    count = len(view.shown.cameras)
    return [replace(view, time=frame / count) for frame in range(count)]


def _view_frames(view: ViewRequest) -> Iterator[ByteImage]:
    for moment in _view_moments(view):
        (drawn,) = draw_view(moment)
        yield drawn.image


def _view_video_facts(view: ViewRequest) -> dict[str, Any]:
    """As `vesselsplat export --video` says it."""
    facts = {"kind": "render video"} | view_facts(view)
    return facts | {
        "moments": [
            {"time": one.time, "camera": one.camera.to_json(), "near": one.near}
            for one in _view_moments(view)
        ]
    }


def _measures(request: ExportRequest, path: Path) -> Iterator[Step]:
    """A table and the same as JSON: every pane at every frame, against the photo."""
    maker, rows = OtherMaker(), []
    for frame in range(request.steps):
        clip = request.shots[0].photo.clip
        photo = clip.read_image(frame)
        view = field_of_view(photo)
        vessels = vessel_mask(photo, tissue_mask=view)
        for shot in request.shots:
            image = panel(shot.at(frame), maker, 1)[0].image
            found = asdict(measured(image, photo, vessels, view, 0.0))
            del found["milliseconds"]
            rows.append({"frame": frame, "label": clip.labels[frame], "pane": shot.title} | found)
        yield Step(frame + 1)
    panes = [shot.facts for shot in request.shots]
    definitions = {name: text for name, text in DEFINITIONS.items() if name != "milliseconds"}
    facts = provenance(kind="measures", **_facts(request), panes=panes, frames=rows, definitions=definitions)
    write_bytes(path.with_suffix(".json"), strict_json(facts, indent=1).encode())
    write_bytes(path, _table(rows))
    yield Step(request.steps, path)


def _table(rows: list[dict[str, Any]]) -> bytes:
    """CSV; an empty field is what could not be measured."""
    text = io.StringIO()
    names = ["frame", "label", "pane", *(name for name in METRICS if name != "milliseconds")]
    writer = csv.DictWriter(text, names)
    writer.writeheader()
    for row in rows:
        writer.writerow({name: "" if value != value else value for name, value in row.items()})
    return text.getvalue().encode()
