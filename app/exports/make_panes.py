"""What the window shows, of its records: panes and 3D views as pictures or videos, panes as a table."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

from app.enhancement.frame_enhancer import PictureRequest
from app.enhancement.methods import METHODS
from app.errors import UserError
from app.exports.comparison_images import OtherMaker
from app.exports.make_drawn import view_of
from app.exports.measure_table import Row, measured_rows, write_measures
from app.exports.page import Panel, sheet
from app.exports.records import MeasuresTable, PaneRecord, PanesPicture, PanesRecord, PanesVideo, SpanRecord
from app.exports.shots import Panes, Shot
from app.exports.sizing import Sizing
from app.exports.sources import Sources
from app.exports.view_pages import drawn_panel
from app.files.atomic import together
from app.files.image_series import timing_of
from app.files.provenance import write_png, write_sidecar
from app.files.video import write_frames
from app.scenes.records import ViewRecord
from app.scenes.scene import Scene
from renderer.clip import Clip
from renderer.near_plane import NEAR_SHARE


def make_picture(record: PanesPicture, sources: Sources, target: Path) -> None:
    """Panes, the 3D view, or both. Raises UserError, ClipError or ImageError."""
    panels: list[Panel] = []
    if record.source is not None:
        panes = panes_of(record, sources)
        made = panes.made(OtherMaker())
        panels += panes.laid_out(made)
        pairs = zip(record.panes, made, strict=True)
        record = replace(record, panes=tuple(replace(pane, statistics=one.statistics) for pane, one in pairs))
    for view in record.views:
        panels.append(drawn_panel(view_of(view, sources, trained=False), sources.drawer(view.renderer)))
    if not panels:
        raise UserError("expected panes or a 3D view, got neither")
    views = tuple(replace(view, renderer=sources.drawer(view.renderer).name) for view in record.views)
    write_png(target, sheet(panels), replace(record, views=views).signed)


def make_video(record: PanesVideo, sources: Sources, target: Path) -> Generator[int, None, None]:
    """Raises UserError, ClipError or ImageError."""
    panes, frames = _panes_and_frames(record, sources)
    if record.arrangement.top is None:
        panes = panes.steady(OtherMaker())
    timing = timing_of(panes.shots[0].photo.clip, frames)
    timing = replace(timing, frames_per_second=record.frames_per_second)
    with together(target) as place:
        written = yield from write_frames(place, panes.pages(frames), timing)
        write_sidecar(place, replace(record, arrangement=panes.arrangement, video=written).signed)


def make_measures(record: MeasuresTable, sources: Sources, target: Path) -> Generator[int, None, None]:
    """The table and the JSON beside it. Raises UserError, ClipError or ImageError."""
    panes, frames = _panes_and_frames(record, sources)
    rows: list[Row] = []
    for done, rows_of_frame in enumerate(measured_rows(panes, frames), start=1):
        rows += rows_of_frame
        yield done
    write_measures(target, rows, record)


def _panes_and_frames(record: SpanRecord, sources: Sources) -> tuple[Panes, range]:
    """Raises UserError for frames that the clip does not have."""
    panes = panes_of(record, sources)
    count = len(panes.shots[0].photo.clip)
    if not 0 <= record.first_frame <= record.last_frame < count:
        got = f"{record.first_frame} to {record.last_frame}"
        raise UserError(f"expected frames from 0 to {count - 1}, got {got}")
    return panes, range(record.first_frame, record.last_frame + 1)


def panes_of(record: PanesRecord, sources: Sources) -> Panes:
    """Raises UserError or ClipError."""
    if record.source is None or not record.panes:
        raise UserError("expected panes of a clip, got none")
    clip, frame = sources.clip(record.source, record.clip_options), record.frame.index
    if not 0 <= frame < len(clip):
        raise UserError(f"expected panes of one of {len(clip)} frames, got frame {frame}")
    shots = tuple(_shot(pane, clip, frame, sources) for pane in record.panes)
    return Panes(shots, record.arrangement, Sizing(record.scale, record.width))


def _shot(pane: PaneRecord, clip: Clip, frame: int, sources: Sources) -> Shot:
    photo = PictureRequest(clip, frame, None, pane.scope, pane.tissue_only, pane.mask, pane.span)
    shot = Shot(pane.title, photo)
    if pane.shows == "original":
        return shot
    if pane.shows == "render" and pane.view is not None:
        return replace(shot, by=_scene(pane.view, sources))
    by = pane.params if pane.shows == "setting" else pane.method
    if by is None or (isinstance(by, str) and by not in METHODS):
        raise UserError(f"expected settings or a method for {pane.title}, got neither")
    return replace(shot, by=by)


def _scene(view: ViewRecord, sources: Sources) -> Scene:
    """As the window shows it through the clip's cameras."""
    scene = sources.scene(view)
    if view.near is None or view.near == scene.near:
        return scene
    return replace(scene, distance=view.near / NEAR_SHARE)
