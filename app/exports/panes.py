"""The panes of a record: made at any frame and set against each other as on the screen."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from app.enhancement.clip_statistics import ClipMeasurer, OfClip, StatisticsRequest
from app.enhancement.frame_enhancer import PictureRequest
from app.enhancement.methods import METHODS, EnhancementSettings
from app.enhancement.records import told_in_full
from app.enhancement.setting_words import in_letters, with_method, worded
from app.errors import UserError
from app.exports.comparison_images import (
    Difference,
    DifferenceRequest,
    OtherMaker,
    OtherRequest,
    heat_map,
    heat_scale,
)
from app.exports.records import Arrangement, PaneRecord, PanesRecord
from app.exports.sheet import Panel, describe
from app.exports.sizing import Sizing
from app.exports.sources import Sources
from app.scenes.backgrounds import Background
from app.scenes.color_bar import INK, with_bar
from app.scenes.cpu_rendering import ON_CPU
from app.scenes.records import ViewRecord
from app.scenes.scene import Scene
from app.scenes.view_kinds import Composed
from app.scenes.view_request import ViewRequest, view_record
from enhance import EnhanceParams, Statistics
from enhance.vessel import VesselParams
from renderer.clip import ByteImage
from renderer.near_plane import NEAR_SHARE
from renderer.unobserved import BLACK, GREY

Shown = EnhancementSettings | str | Scene | None
"""A setting, a method without parameters, or a model; None: the frame itself."""

SAID: Final = {None: in_letters, "interface": worded, "method": with_method}


def pane_record(
    title: str, original: PictureRequest, by: Shown = None, background: Background = GREY
) -> PaneRecord:
    """Of a frame and how its statistics are taken, whatever its own params."""
    view = None
    if isinstance(by, Scene):
        seen = replace(ViewRequest.of_clip_frame(by, original.frame_index), background=background)
        view = view_record(seen, ON_CPU)
    method = by if isinstance(by, str) else None
    params = by if isinstance(by, EnhanceParams | VesselParams) else None
    return PaneRecord(
        title=title,
        shows="render" if view else "method" if method else "setting" if params else "original",
        scope=original.scope,
        pixels=original.pixels,
        mask=original.mask,
        span=original.span,
        params=params,
        drawn_tools=True if params is not None and original.tools is not None else None,
        method=method,
        view=view,
        words="method",
    )


@dataclass(frozen=True, eq=False)
class Made:
    """The picture of one pane in the size of the file, with what it was made with."""

    panel: Panel
    statistics: Statistics | None = None


class PaneMaker:
    """Makes the panes of a record; remembers what one frame has in common with the next.

    Raises UserError or ClipError: there are none, or what they are of is not there.
    """

    def __init__(self, record: PanesRecord, sources: Sources) -> None:
        if record.source is None or not record.panes:
            raise UserError("expected panes of a clip, got none")
        self.clip = sources.clip(record.source, record.clip_options)
        count, frame = len(self.clip), record.frame.index
        if not 0 <= frame < count:
            raise UserError(f"expected panes of one of {count} frames, got frame {frame}")
        self._record, self._maker, self._sources = record, OtherMaker(), sources
        self._measured: dict[StatisticsRequest, OfClip] = {}
        self._panes = [(pane, _shown(pane, sources)) for pane in record.panes]

    def measure(self) -> Iterator[int]:
        """The statistics of the clip that panes need and nobody knows yet: 0 after each frame.

        Raises ClipError or ImageError.
        """
        for pane, by in self._panes:
            if not isinstance(by, EnhanceParams | VesselParams) or _known(pane, by) is not None:
                continue
            wanted = self._request(pane, 0).statistics_request(by)
            if wanted in self._measured or self._sources.of_clip(wanted) is not None:
                continue
            for found in ClipMeasurer().measure(wanted):
                yield 0
                if found is not None:
                    self._measured[wanted] = found.told(wanted)

    def _request(self, pane: PaneRecord, frame: int) -> PictureRequest:
        return PictureRequest(self.clip, frame, None, pane.scope, pane.pixels, pane.mask, pane.span)

    def made(self, frame: int, sizing: Sizing | None = None) -> list[Made]:
        """Each on its own, in the size of the record or another one. Raises ClipError or ImageError."""
        size = sizing or Sizing(self._record.scale, self._record.width)
        return [self._made(pane, by, frame, size) for pane, by in self._panes]

    def panels(self, frame: int, arrangement: Arrangement) -> list[Panel]:
        """What stands on the page. Raises ClipError or ImageError."""
        return arranged([one.panel for one in self.made(frame)], arrangement)

    def steady(self) -> Arrangement:
        """A difference with the scale of the record's frame at all frames, so that they can be compared."""
        arrangement = self._record.arrangement
        if arrangement.mode != "difference" or arrangement.top is not None or len(self._panes) != 2:
            return arrangement
        left, right = (one.panel.image for one in self.made(self._record.frame.index))
        return replace(arrangement, top=difference(left, right).top)

    def _made(self, pane: PaneRecord, by: Shown, frame: int, sizing: Sizing) -> Made:
        if by is None:
            label = self.clip.labels[frame]
            # A number alone counts from 0, other than the window does.
            label = f"frame {frame + 1}" if pane.words is not None and label.isdecimal() else label
            return Made(Panel(f"{pane.title}   {label}", sizing.of(self.clip.read_image(frame))))
        original = self._request(pane, frame)
        if isinstance(by, EnhanceParams | VesselParams):
            wanted = original.statistics_request(by)
            given = _known(pane, by)
            known = given or self._sources.of_clip(wanted) or self._measured.get(wanted)
            scope = original.scope if given is None else "clip"
            original = replace(original, scope=scope, of_clip=known)
        behind = (pane.view and pane.view.background) or BLACK
        (other,) = self._maker.make(OtherRequest(original, by, behind))
        said = describe(other.made, SAID[pane.words]) if other.made is not None else ""
        used = other.made.statistics if other.made is not None else None
        return Made(Panel(f"{pane.title}   {said}".rstrip(), sizing.of(other.image)), used)


def _known(pane: PaneRecord, by: EnhancementSettings) -> Statistics | None:
    """With which a pane is made, whatever its clip; None: to be measured."""
    return pane.given or told_in_full(pane.statistics, pane.pixels, by)


def _shown(pane: PaneRecord, sources: Sources) -> Shown:
    if pane.shows == "original":
        return None
    if pane.shows == "render" and pane.view is not None:
        return _scene(pane.view, sources)
    by = pane.params if pane.shows == "setting" else pane.method
    if by is None or (isinstance(by, str) and by not in METHODS):
        raise UserError(f"expected a setting or a method for {pane.title}, got neither")
    return by


def _scene(view: ViewRecord, sources: Sources) -> Scene:
    """As the window shows it through the clip's cameras."""
    scene, near = sources.scene(view), view.near
    return scene if near is None or near == scene.near else replace(scene, distance=near / NEAR_SHARE)


def arranged(panels: Sequence[Panel], arrangement: Arrangement) -> list[Panel]:
    """One panel a pane, or one for both with both captions."""
    if len(panels) != 2 or arrangement.mode == "side by side":
        return list(panels)
    left, right = panels
    if arrangement.mode == "wipe":
        return [Panel(f"{left.label}\n{right.label}", _wiped(left.image, right.image, arrangement.wipe))]
    apart = difference(left.image, right.image, arrangement.top)
    picture = with_bar(Composed(apart.heat, heat_scale(apart.top)))
    said = f"Difference   largest of R, G, B   mean {apart.mean:.1f}"
    return [Panel(f"{said}\n{left.label}\n{right.label}", picture)]


def difference(left: ByteImage, right: ByteImage, top: int | None = None) -> Difference:
    """The heat map of two pictures of one size; `top` in grey levels as in `Arrangement`."""
    (apart,) = heat_map(DifferenceRequest(left, right), top)
    return apart


def _wiped(left: ByteImage, right: ByteImage, share: float) -> ByteImage:
    """(H, W + line, 3): a line between the two, which hides no pixel of either."""
    column, weight = round(share * left.shape[1]), max(1, left.shape[1] // 400)
    line = np.full((left.shape[0], weight, 3), INK, np.uint8)
    return np.concatenate([left[:, :column], line, right[:, column:]], axis=1)
