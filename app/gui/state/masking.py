"""Tool masks of the open clip that are mended by hand. A part of the state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Final

from annotated_types import Interval

from app.gui.work.masking import FrameMask, GrowRequest, KeepMask, MakingRequest, MaskRequest, MasksThere
from app.runs.making_masks import MaskReport
from renderer.clip import BoolImage
from renderer.tools.brush import Point, Stroke
from renderer.tools.mask_files import MaskOrigin
from renderer.tools.onnx_model import Values

THINNEST, THICKEST = 0.002, 0.2
"""Radius of the brush, as a share of the frame's width."""
MOST_PAST: Final = 40
"""Masks, of whatever frames, that can be gone back to; and as many that can come back."""


@dataclass(frozen=True, eq=False)
class MaskStep:
    """What the mask of a frame was before or after a stroke."""

    request: MaskRequest
    mask: BoolImage
    """(H, W)."""
    origin: MaskOrigin | None

    @classmethod
    def of(cls, frame: FrameMask) -> MaskStep:
        return cls(frame.request, frame.mask, frame.origin)

    def taken(self, frame: FrameMask) -> FrameMask:
        """The frame with this mask."""
        return replace(frame, mask=self.mask, origin=self.origin)


@dataclass
class Masking:
    """Masking actions change it; drawing reads it."""

    active: bool = False
    """Drags over the frame draw."""
    tool: Stroke = "paint"
    radius: Annotated[float, Interval(ge=THINNEST, le=THICKEST)] = 0.02
    """Of the brush, as a share of the frame's width."""
    line: tuple[Point, ...] = ()
    """The stroke under way, in pixels of the frame."""
    hand_on: int | None = None
    """The frame that the hand went down on; None while nothing is held. It draws on no other one."""
    shown: FrameMask | None = None
    """Of the frame on screen, as it is now, with the stroke."""
    past: tuple[MaskStep, ...] = ()
    """Before each stroke on any frame, oldest first."""
    future: tuple[MaskStep, ...] = ()
    """After each stroke that was undone, the next one of a frame last."""
    growing: GrowRequest | None = None
    keeping: tuple[KeepMask, ...] = ()
    """Those that are being written."""
    there: MasksThere | None = None
    """Which there are of the open clip."""
    network_values: Values = "imagenet"
    """Of the pixels that a network takes."""
    network_tools: str = ""
    """Classes of a network that are tools, as typed; empty: all but the first."""
    making: MakingRequest | None = None
    """Masks of all frames are being made."""
    leaving: Callable[[], None] | None = None
    """What waits for an answer to whether another clip may interrupt that."""
    report: MaskReport | None = None
    """How far that is, or how well it went."""
    changes: int = 0
    """How often a mask on disk has changed."""

    @property
    def before(self) -> MaskStep | None:
        """The frame on screen before the last stroke on it; None: there was none, or it is forgotten."""
        return self._last_of(self.past)

    @property
    def after(self) -> MaskStep | None:
        """The frame on screen after the stroke that was undone last; None: there is none."""
        return self._last_of(self.future)

    def _last_of(self, steps: tuple[MaskStep, ...]) -> MaskStep | None:
        request = None if self.shown is None else self.shown.request
        return next((step for step in reversed(steps) if step.request == request), None)

    @property
    def is_busy(self) -> bool:
        """Something is being grown, written or made."""
        return self.growing is not None or self.making is not None or bool(self.keeping)
