"""What a person may have to say about a clip, as its files do not."""

from __future__ import annotations

from typing import Annotated, Final, Literal

from annotated_types import Interval, Unit
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from renderer.clip import Split

DepthSource = Literal["auto", "measured", "stereo", "monocular", "brightness", "off"]

Deinterlacing = Literal["frame", "field", "off"]


@dataclass(
    frozen=True,
    kw_only=True,
    config=ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True),
)
class ClipOptions:
    """How to read what a folder itself does not say; what a layout has no use for is left alone.

    Raises:
        pydantic.ValidationError: (a ValueError) a value out of its range.

    Example:
        >>> from renderer import ClipOptions
        >>> ClipOptions(depth="brightness", frame_step=2).field_of_view  # for open_clip(path, options)
        60.0
    """

    pose_convention: Literal["opencv", "opengl", "llff"] = "opencv"
    """Axes of the camera-to-world matrices of an EndoNeRF folder; all agree for the identity poses of a
    fixed endoscope."""
    mask_polarity: Literal["auto", "tool", "tissue"] = "auto"
    """What the non-zero pixels of the masks mark; auto takes what the layout says, which for EndoNeRF is
    tool, and refuses what looks inverted."""
    evaluation_masks: Literal["masks", "gt_masks"] = "masks"
    """Which masks the metrics count. The published figures multiply by masks, which also leave out
    the pixels without stereo depth; gt_masks count everything but the tools."""
    bottom_rows: Annotated[int, Interval(ge=0, le=256), Unit("px")] | None = None
    """Burned-in rows at the bottom, not supervised; auto: detected."""
    field_of_view: Annotated[float, Interval(ge=5.0, le=170.0)] = 60.0
    """Horizontal, in degrees: taken for pictures and videos without calibration."""
    depth: DepthSource = "auto"
    """Where depth comes from: measured with the clip; matched between left and right pictures; or, without
    a scale, taken from monocular maps beside the pictures or guessed from brightness. Auto: the first of
    these that the clip has, but never a guess."""
    baseline: Annotated[float, Interval(ge=0.01, le=1000.0), Unit("mm")] | None = None
    """Between left and right eye, for stereo depth; auto: from the calibration, else lengths are in units
    of it."""
    frame_step: Annotated[int, Interval(ge=1, le=1000)] | None = None
    """Keep every n-th frame; auto: all, and for SCARED what the field takes for the dataset."""
    deinterlacing: Deinterlacing = "frame"
    """Of interlaced video: one picture a frame, one a field (twice as many), or off, as stored."""
    split: Split = "field"
    """Frames held out of training: every eighth from the second on, as the field does, or the odd ones, as
    it does for Hamlyn."""


DEFAULTS: Final = ClipOptions()
EVERY_OPTION: Final = tuple(ClipOptions.__dataclass_fields__)
"""Names of all options, for the flags."""
