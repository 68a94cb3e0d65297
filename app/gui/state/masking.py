"""Tool masks of the open clip that are mended by hand. A part of the state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Final

from annotated_types import Interval

from app.gui.work.masking import FrameMask, GrowRequest, KeepMask, MakingRequest, MasksThere
from app.runs.making_masks import MaskReport
from renderer.tools.brush import Point, Stroke
from renderer.tools.onnx_model import Values

THINNEST, THICKEST = 0.002, 0.2
"""Radius of the brush, as a share of the frame's width."""
MOST_PAST: Final = 20
"""Masks of a frame that can be gone back to."""


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
    past: tuple[FrameMask, ...] = ()
    """That frame before each stroke, oldest first."""
    future: tuple[FrameMask, ...] = ()
    """That frame after each stroke that was undone, the next one last."""
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
    def is_busy(self) -> bool:
        """Something is being grown, written or made."""
        return self.growing is not None or self.making is not None or bool(self.keeping)
