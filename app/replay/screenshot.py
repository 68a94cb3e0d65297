"""What the window showed, made again."""

from __future__ import annotations

from pathlib import Path

from pydantic import ConfigDict, TypeAdapter
from pydantic.dataclasses import dataclass

from app.errors import UserError
from app.gui.work.enhancing import PictureMaker, PictureRequest, Scope
from app.gui.work.export import Panel, picture_panels, sheet, view_panel
from app.picture_mask import NO_MASK, PictureMask
from app.provenance import write_png
from app.replay.drawn import RENDER, drawer_of, scene_of, view_of
from app.replay.recorded import Facts, again
from app.replay.sources import Named, Sources
from app.run_folder import RecordedLook
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.sources import open_clip


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class FrameFacts:
    """Which frame."""

    index: int


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class PairFacts:
    """What the two pictures say of themselves."""

    source: Named
    frame: FrameFacts
    params: RecordedLook | None = None
    scope: Scope = "image"
    tissue_only: bool = False
    mask: PictureMask = NO_MASK
    span: tuple[int, int] | None = None
    clip_options: ClipOptions = DEFAULTS


PAIR = TypeAdapter(PairFacts)


def remake_screenshot(facts: Facts, sources: Sources, target: Path) -> str | None:
    """Raises UserError, ClipError, ImageError or pydantic.ValidationError."""
    panels: list[Panel] = []
    if "source" in facts:
        panels += _pair(PAIR.validate_python(facts), sources)
    name = None
    if "view" in facts:
        view = facts["view"]
        draw, name = drawer_of(view)
        scene = scene_of(view, sources)
        kind = RENDER.validate_python(view).view
        image = view_of(scene, view, sources, draw, trained=False)
        panels.append(view_panel(scene.name, image, kind))
    write_png(target, sheet(panels), again(facts))
    return name


def _pair(facts: PairFacts, sources: Sources) -> list[Panel]:
    clip = open_clip(sources.find(facts.source), facts.clip_options)
    if not 0 <= facts.frame.index < len(clip):
        raise UserError(f"expected one of {len(clip)} frames, got {facts.frame.index}: {clip.path}")
    request = PictureRequest(
        clip, facts.frame.index, facts.params, facts.scope, facts.tissue_only, facts.mask, facts.span
    )
    return picture_panels(list(PictureMaker().make(request))[-1])
