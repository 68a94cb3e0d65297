"""What can be set in the window: words, ranges and lengths, for its controls and for files that keep it."""

from __future__ import annotations

from collections.abc import Collection, Sized
from typing import Annotated, Any, Final, Literal, get_args

from annotated_types import Interval
from pydantic import AfterValidator, BeforeValidator

from app.enhancement.methods import METHODS
from enhance.shown import Named

Mode = Literal["side by side", "wipe", "flip", "difference"]
Slot = Literal["A", "B"]
Scope = Literal["automatic", "image", "clip"]
"""Statistics of one picture, or of the whole clip; automatic: of the clip where it is a recording."""
Pixels = Literal["automatic", "all", "tissue"]
"""What counts in the statistics: the field of view, outside of which nothing is enhanced; every pixel; or
neither tools nor what is black at the border, while every pixel is enhanced."""
InputKind = Literal["original", "enhanced", "both in turn"]

MODES: Final[tuple[Mode, ...]] = get_args(Mode)
PIXELS: Final[tuple[Pixels, ...]] = get_args(Pixels)
SCOPES: Final[tuple[Scope, ...]] = get_args(Scope)
SLOTS: Final[tuple[Slot, ...]] = get_args(Slot)
ORIGINAL: Final = "original"
ENHANCED: Final = "enhanced"
RENDER: Final = "render"
SOURCES: Final = (ORIGINAL, ENHANCED, *SLOTS, RENDER, *METHODS)
"""What a pane can show: the frame, the frame enhanced as set now, by a stored setting, or by another method
with its own defaults, and the picture that the open reconstruction gives of the same moment."""

MIN_ZOOM, MAX_ZOOM = 0.05, 40.0
"""Pane pixels a picture pixel."""
POOLED_FRAMES: Final = 16
"""Frames, evenly spread, whose statistics stand for the whole clip."""
MOST_VALUES: Final = 12
"""Of one parameter that is tuned."""
MOST_FRAME: Final = 2**31 - 1
"""Number of a frame: what a control can hold."""
LONGEST_NAME: Final = 100
"""Characters of what a person calls a preset or a run."""
LONGEST_NOTES: Final = 100_000
LONGEST_PATH: Final = 32_767
"""Characters that Windows allows; other systems allow fewer."""


def drawn(pixels: Pixels) -> Named:
    """What is enhanced."""
    return "automatic" if pixels == "automatic" else "all"


def renamed(given: Any) -> Any:
    """Of a file that keeps `pixels`: as an earlier version says it, tissue only or all."""
    if not isinstance(given, dict) or "tissue_only" not in given or "pixels" in given:
        return given
    return given | {"pixels": "tissue" if given["tissue_only"] else "all"}


def at_most(length: int) -> BeforeValidator:
    """Of text, a list or an object: looked at before its items, of which there may be millions."""

    def bounded(value: Any) -> Any:
        if isinstance(value, Sized) and len(value) > length:
            raise ValueError(f"expected a length of at most {length}, got {len(value)}")
        return value

    return BeforeValidator(bounded)


def one_of(words: Collection[str]) -> AfterValidator:
    """Text that is one of these."""

    def known(word: str) -> str:
        if word not in words:
            raise ValueError(f"expected one of {', '.join(filter(None, words))}")
        return word

    return AfterValidator(known)


Share = Annotated[float, Interval(ge=0.0, le=1.0)]
Zoom = Annotated[float, Interval(ge=MIN_ZOOM, le=MAX_ZOOM)]
FrameNumber = Annotated[int, Interval(ge=0, le=MOST_FRAME)]
Source = Annotated[str, one_of(SOURCES)]
Name = Annotated[str, at_most(LONGEST_NAME)]
Notes = Annotated[str, at_most(LONGEST_NOTES)]
PathText = Annotated[str, at_most(LONGEST_PATH)]
