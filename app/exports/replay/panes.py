"""What the window showed, reproduced: panes and 3D views as images or videos, panes as a table."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from pydantic import ConfigDict, TypeAdapter
from pydantic.dataclasses import dataclass

from app.enhancement.frame_enhancer import PictureRequest
from app.enhancement.image_mask import NO_MASK, PictureMask
from app.enhancement.methods import METHODS
from app.enhancement.settable import Scope
from app.errors import UserError
from app.exports.comparison_images import OtherMaker
from app.exports.measure_table import MADE_AGAIN, measured_rows, write_measures
from app.exports.page import sheet
from app.exports.replay.drawn import at, drawer_of, scene_of, view_of
from app.exports.replay.recorded import Facts, again
from app.exports.replay.sources import Named, Sources
from app.exports.shots import Arrangement, Panes, Shot
from app.exports.sizing import Sizing
from app.exports.view_pages import drawn_panel, view_pages
from app.files.image_series import timing_of
from app.files.provenance import write_png, write_sidecar
from app.files.video import Timing, write_video
from app.runs.run_folder import RecordedSettings
from app.scenes.scene import Scene
from renderer.clip import Clip
from renderer.near_plane import NEAR_SHARE
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.sources import open_clip


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class PaneFacts:
    """What one pane says of itself."""

    title: str
    shows: Literal["original", "setting", "method", "render"]
    scope: Scope
    tissue_only: bool
    mask: PictureMask = NO_MASK
    span: tuple[int, int] | None = None
    params: RecordedSettings | None = None
    method: str = ""
    view: dict[str, Any] | None = None


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class FrameFacts:
    """Which frame."""

    index: int


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class PanesFacts:
    """What panes of a picture, a video or a table say of themselves."""

    source: Named
    panes: tuple[PaneFacts, ...]
    clip_options: ClipOptions = DEFAULTS
    scale: int = 1
    width: int | None = None
    arrangement: Arrangement = Arrangement()
    frame: FrameFacts = FrameFacts(0)


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class SpanFacts:
    """Which frames a video or a table of panes has."""

    first_frame: int
    last_frame: int
    frames_per_second: float = 15.0

    def frames(self, panes: Panes) -> range:
        """Raises UserError for frames that the clip does not have."""
        count = len(panes.shots[0].photo.clip)
        if not 0 <= self.first_frame <= self.last_frame < count:
            got = f"{self.first_frame} to {self.last_frame}"
            raise UserError(f"expected frames from 0 to {count - 1}, got {got}")
        return range(self.first_frame, self.last_frame + 1)


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class ViewVideoFacts:
    """What a video of the 3D view, or of both, says of itself."""

    views: tuple[Facts, ...]
    moments: tuple[Facts, ...]
    frames_per_second: float


PANES, SPAN = TypeAdapter(PanesFacts), TypeAdapter(SpanFacts)
VIEW_VIDEO = TypeAdapter(ViewVideoFacts)


def remake_panes(facts: Facts, sources: Sources, target: Path) -> str | None:
    """Panes, the 3D view, or both. Raises UserError, ClipError, ImageError or pydantic.ValidationError."""
    panels = panes_of(facts, sources).panels(OtherMaker()) if "source" in facts else []
    name = None
    for said in facts.get("views", []):
        draw, name = drawer_of(said)
        panels.append(drawn_panel(view_of(said, sources, trained=False), draw))
    if not panels:
        raise UserError(f"expected panes or a 3D view, got neither: {sources.file}")
    write_png(target, sheet(panels), again(facts))
    return name


def remake_view_video(facts: Facts, sources: Sources, target: Path) -> str:
    """The 3D view, or both. Raises UserError, ClipError, ImageError or pydantic.ValidationError."""
    said = VIEW_VIDEO.validate_python(facts)
    if not (said.views and said.moments):
        raise UserError(f"expected at least one 3D view and one frame, got none: {sources.file}")
    draw, name = drawer_of(said.views[0])
    first = [(one, view_of(one | said.moments[0], sources, trained=False)) for one in said.views]
    moments = (tuple(at(view, one | moment) for one, view in first) for moment in said.moments)
    write_video(target, view_pages(moments, draw), Timing(said.frames_per_second))
    write_sidecar(target, again(facts))
    return name


def remake_panes_video(facts: Facts, sources: Sources, target: Path) -> None:
    """Raises UserError, ClipError, ImageError or pydantic.ValidationError."""
    span, panes = SPAN.validate_python(facts), panes_of(facts, sources)
    frames = span.frames(panes)
    timing = timing_of(panes.shots[0].photo.clip, frames)
    write_video(target, panes.pages(frames), replace(timing, frames_per_second=span.frames_per_second))
    write_sidecar(target, again(facts))


def remake_measures(facts: Facts, sources: Sources, target: Path) -> None:
    """The table and the JSON beside it. Raises UserError, ClipError, ImageError or ValidationError."""
    panes = panes_of(facts, sources)
    frames = SPAN.validate_python(facts).frames(panes)
    rows = [row for rows_of_frame in measured_rows(panes, frames) for row in rows_of_frame]
    kept = {name: value for name, value in again(facts).items() if name not in ("kind", *MADE_AGAIN)}
    write_measures(target, rows, kept)


def panes_of(facts: Facts, sources: Sources) -> Panes:
    """Raises UserError, ClipError or pydantic.ValidationError."""
    said = PANES.validate_python(facts)
    clip, frame = open_clip(sources.find(said.source), said.clip_options), said.frame.index
    if not (said.panes and 0 <= frame < len(clip)):
        raise UserError(f"expected panes of one of {len(clip)} frames, got frame {frame}: {sources.file}")
    shots = tuple(_shot(pane, clip, frame, sources) for pane in said.panes)
    return Panes(shots, said.arrangement, Sizing(said.scale, said.width))


def _shot(pane: PaneFacts, clip: Clip, frame: int, sources: Sources) -> Shot:
    photo = PictureRequest(clip, frame, None, pane.scope, pane.tissue_only, pane.mask, pane.span)
    shot = Shot(pane.title, photo)
    if pane.shows == "original":
        return shot
    if pane.shows == "render" and pane.view is not None:
        return replace(shot, by=_scene(pane.view, sources))
    by = pane.params if pane.shows == "setting" else pane.method
    if by is None or (isinstance(by, str) and by not in METHODS):
        raise UserError(f"expected settings or a method for {pane.title}, got neither: {sources.file}")
    return replace(shot, by=by)


def _scene(view: dict[str, Any], sources: Sources) -> Scene:
    """As the window shows it through the clip's cameras."""
    scene = scene_of(view, sources)
    return replace(scene, distance=float(view.get("near", scene.near)) / NEAR_SHARE)
