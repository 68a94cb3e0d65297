"""Panes of the window as a picture or a video, made again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from pydantic import ConfigDict, TypeAdapter
from pydantic.dataclasses import dataclass

from app.errors import UserError
from app.gui.work.enhancing import PictureRequest, Scope
from app.gui.work.export import sheet
from app.gui.work.others import OtherMaker
from app.gui.work.shots import Shot, panel
from app.gui.work.viewing import ShownModel
from app.methods import METHODS
from app.pictures import ArrayImage
from app.provenance import write_png, write_sidecar
from app.replay.drawn import scene_of
from app.replay.recorded import Facts, again
from app.replay.screenshot import FrameFacts
from app.replay.sources import Named, Sources
from app.run_folder import RecordedLook
from app.video import write_video
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
    params: RecordedLook | None = None
    method: str = ""
    view: dict[str, Any] | None = None


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class PanesFacts:
    """What a picture or a video of panes says of itself."""

    source: Named
    panes: tuple[PaneFacts, ...]
    clip_options: ClipOptions = DEFAULTS
    scale: int = 1
    frame: FrameFacts = FrameFacts(0)
    frames: int = 0
    frames_per_second: float = 15.0


PANES = TypeAdapter(PanesFacts)


def remake_panes(facts: Facts, sources: Sources, target: Path) -> None:
    """Raises UserError, ClipError, ImageError or pydantic.ValidationError."""
    said = PANES.validate_python(facts)
    shots = _shots(said, sources, said.frame.index)
    write_png(target, _sheet(shots, said.scale, OtherMaker()), again(facts))


def remake_panes_video(facts: Facts, sources: Sources, target: Path) -> None:
    """Raises UserError, ClipError, ImageError or pydantic.ValidationError."""
    said = PANES.validate_python(facts)
    shots, maker = _shots(said, sources, max(said.frames - 1, 0)), OtherMaker()

    def frames() -> Iterator[ArrayImage]:
        for frame in range(said.frames):
            yield _sheet([shot.at(frame) for shot in shots], said.scale, maker)

    write_video(target, frames(), said.frames_per_second)
    write_sidecar(target, again(facts))


def _sheet(shots: list[Shot], scale: int, maker: OtherMaker) -> ArrayImage:
    return sheet([panel(shot, maker, scale)[0] for shot in shots])


def _shots(said: PanesFacts, sources: Sources, frame: int) -> list[Shot]:
    clip = open_clip(sources.find(said.source), said.clip_options)
    if not (said.panes and 0 <= frame < len(clip) and said.scale >= 1):
        raise UserError(f"expected panes of one of {len(clip)} frames, got frame {frame}: {sources.file}")
    return [_shot(pane, clip, frame, sources) for pane in said.panes]


def _shot(pane: PaneFacts, clip: Clip, frame: int, sources: Sources) -> Shot:
    photo = PictureRequest(clip, frame, None, pane.scope, pane.tissue_only)
    shot = Shot(pane.title, photo)
    if pane.shows == "original":
        return shot
    if pane.shows == "render" and pane.view is not None:
        return replace(shot, by=_model(pane.view, sources))
    by = pane.params if pane.shows == "setting" else pane.method
    if by is None or (isinstance(by, str) and by not in METHODS):
        raise UserError(f"expected a setting or a method for {pane.title}, got neither: {sources.file}")
    return replace(shot, by=by)


def _model(view: dict[str, Any], sources: Sources) -> ShownModel:
    """The model as the window shows it through the clip's cameras."""
    scene = scene_of(view, sources)
    distance = float(view.get("near", 1.0)) / NEAR_SHARE
    return ShownModel(
        scene.model, scene.cameras, distance, scene.name, 0, 0, live=False, mode=scene.mode, unit=scene.unit
    )
