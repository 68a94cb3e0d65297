"""What panes show, by value: made at any frame and set against each other as on the screen."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from app.enhancement.frame_enhancer import PictureRequest
from app.enhancement.methods import EnhancementSettings
from app.exports.comparison_images import Difference, DifferenceRequest, OtherMaker, OtherRequest, heat_map
from app.exports.page import INK, Panel, describe, sheet
from app.exports.records import Arrangement, PaneRecord
from app.exports.sizing import Sizing
from app.scenes.color_bar import with_bar
from app.scenes.cpu_rendering import ON_CPU
from app.scenes.scene import Scene
from app.scenes.view_kinds import Composed, Scale
from app.scenes.view_request import ViewRequest, view_record
from enhance import EnhanceParams, Statistics
from enhance.vessel import VesselParams
from renderer.clip import ByteImage


@dataclass(frozen=True)
class Shot:
    """What one pane shows, at any frame."""

    title: str
    photo: PictureRequest
    """The frame, and how statistics are taken; its own params do not matter."""
    by: EnhancementSettings | str | Scene | None = None
    """A setting, a method without parameters, or a model; None: the photo."""

    def at(self, frame: int) -> Shot:
        return replace(self, photo=replace(self.photo, frame_index=frame))

    @property
    def record(self) -> PaneRecord:
        """Enough to make it again, beside the clip and the frame."""
        photo, by = self.photo, self.by
        view = None
        if isinstance(by, Scene):
            view = view_record(ViewRequest.of_clip_frame(by, photo.frame_index), ON_CPU)
        method = by if isinstance(by, str) else None
        params = by if isinstance(by, EnhanceParams | VesselParams) else None
        return PaneRecord(
            title=self.title,
            shows="render" if view else "method" if method else "setting" if params else "original",
            scope=photo.scope,
            tissue_only=photo.tissue_only,
            mask=photo.mask,
            span=photo.span,
            params=params,
            method=method,
            view=view,
        )


@dataclass(frozen=True, eq=False)
class Made:
    """The picture of one pane in the size of the file, with what it was made with."""

    panel: Panel
    statistics: Statistics | None = None


@dataclass(frozen=True)
class Panes:
    """One or two panes, how they are laid out, and how large."""

    shots: tuple[Shot, ...] = ()
    arrangement: Arrangement = field(default_factory=Arrangement)
    sizing: Sizing = field(default_factory=Sizing)

    def at(self, frame: int) -> Panes:
        return replace(self, shots=tuple(shot.at(frame) for shot in self.shots))

    def made(self, maker: OtherMaker) -> list[Made]:
        """Each on its own. Raises ClipError or ImageError."""
        return [made(shot, maker, self.sizing) for shot in self.shots]

    def laid_out(self, panes: Sequence[Made]) -> list[Panel]:
        """What stands on the page."""
        return arranged([one.panel for one in panes], self.arrangement)

    def panels(self, maker: OtherMaker) -> list[Panel]:
        """Raises ClipError or ImageError."""
        return self.laid_out(self.made(maker))

    def pages(self, frames: Iterable[int]) -> Iterator[ByteImage]:
        """One a frame. Raises ClipError or ImageError."""
        maker = OtherMaker()
        for frame in frames:
            yield sheet(self.at(frame).panels(maker))

    def steady(self, maker: OtherMaker) -> Panes:
        """A difference with the scale of this frame at all frames, so that they can be compared."""
        if self.arrangement.mode != "difference" or len(self.shots) != 2:
            return self
        left, right = (one.panel.image for one in self.made(maker))
        return replace(self, arrangement=replace(self.arrangement, top=difference(left, right).top))


def made(shot: Shot, maker: OtherMaker, sizing: Sizing) -> Made:
    """Raises ClipError or ImageError."""
    photo = shot.photo
    label = photo.clip.labels[photo.frame_index]
    if shot.by is None:
        image = photo.clip.read_image(photo.frame_index)
        return Made(Panel(f"{shot.title}   {label}", sizing.of(image)))
    (other,) = maker.make(OtherRequest(replace(photo, params=None), shot.by))
    said = describe(other.made) if other.made is not None else ""
    used = other.made.statistics if other.made is not None else None
    return Made(Panel(f"{shot.title}   {said}".rstrip(), sizing.of(other.image)), used)


def arranged(panels: Sequence[Panel], arrangement: Arrangement) -> list[Panel]:
    """One panel a pane, or one for both with both captions."""
    if len(panels) != 2 or arrangement.mode == "side by side":
        return list(panels)
    left, right = panels
    if arrangement.mode == "wipe":
        return [Panel(f"{left.label}\n{right.label}", _wiped(left.image, right.image, arrangement.wipe))]
    apart = difference(left.image, right.image, arrangement.top)
    picture = with_bar(Composed(apart.heat, Scale(0.0, apart.top, "grey levels", "inferno")))
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
