"""What of a clip's frames is no tissue though its masks do not say so: found before training sees them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

from app.runs import burned_in, dark_surround, unmasked_tools
from app.runs.clip_selection import WHOLE, ClipPart
from enhance.field import FieldOfView
from renderer.clip import Clip, Frame
from renderer.train.config import Part
from renderer.train.events import Omission

BEFORE: Final[tuple[Part, ...]] = ("surround", "tools")
"""Parts that `with_found` decides on."""


def with_found(
    part: ClipPart,
    read_frame: Callable[[int], Frame],
    indices: Sequence[int],
    keep: Sequence[Part],
    is_followed: bool = False,
) -> ClipPart:
    """The part without the dark surround or thin dark bars at the border, and the tools that some of these
    frames show, unless they are kept or known; where they are known, without what is burned in beside their
    masks. Where the camera `is_followed` also without the rim of the surround and any bars at the border,
    which stay where it moves."""
    if {"surround", "tools"} <= set(keep):
        return part
    looked_at = dark_surround.spread(indices)
    field = part.field_of_view or _field(read_frame, looked_at, is_followed)
    if "surround" not in keep:
        part = replace(part, field_of_view=field)
    if "tools" not in keep and part.tools is None:
        frames = (part.cleared(read_frame(index)) for index in looked_at)
        part = replace(part, tools=unmasked_tools.tools_in(frames))
    if "tools" not in keep and part.burned_in is None:
        # A surround that is kept looks the same in every frame, too.
        lit = replace(part, tools=None, field_of_view=field)
        frames = (lit.cleared(read_frame(index)) for index in looked_at)
        part = replace(part, burned_in=burned_in.burned_in_of(frames))
    return part


def _field(
    read_frame: Callable[[int], Frame], looked_at: Sequence[int], is_followed: bool
) -> FieldOfView | None:
    """What is left of these frames without the surround, or bars at the border; None: all of it."""
    field = dark_surround.lit_field(map(read_frame, looked_at))
    if is_followed and field is not None:
        return dark_surround.without_rim(field)
    if is_followed:
        return dark_surround.without_borders([read_frame(index).image for index in looked_at])
    return dark_surround.without_dark_bars(map(read_frame, looked_at)) if field is None else field


def found_around(clip: Clip, index: int) -> tuple[ClipPart, Frame]:
    """What training would find, judged by this frame, the first and the last; and the frame. Raises
    ClipError."""
    looked_at = sorted({0, index, len(clip) - 1})
    frames = {place: clip.read_frame(place) for place in looked_at}
    return with_found(WHOLE, frames.__getitem__, looked_at, ()), frames[index]


def left_out_of(part: ClipPart) -> tuple[list[Omission], list[str]]:
    """What is left out, and the same in lines for the start of training."""
    omitted, lines = list[Omission](), list[str]()
    if part.field_of_view is not None:
        surround = dark_surround.omission_of(part.field_of_view)
        omitted.append(surround)
        lines.append(f"left out: the dark surround, {surround.saves}")
    if part.tools is not None:
        tools = unmasked_tools.omission_of(part.tools)
        omitted.append(tools)
        lines.append(f"left out: tools, {tools.why}: {tools.saves} (--keep tools reconstructs them)")
    if part.burned_in is not None:
        text = burned_in.omission_of(part.burned_in)
        omitted.append(text)
        lines.append(f"left out: {text.what}, {text.why}: {text.saves} (--keep tools reconstructs them)")
    return omitted, lines
