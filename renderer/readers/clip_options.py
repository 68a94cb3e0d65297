"""Options for what the files of a clip do not state."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Final, Literal

from annotated_types import Interval, Unit
from pydantic import BeforeValidator, ConfigDict
from pydantic.dataclasses import dataclass

from renderer.clip import ClipError, Split
from renderer.readers.lenses.calibration import Calibration
from renderer.utf8_paths import spelled

DepthSource = Literal["auto", "measured", "stereo", "monocular", "brightness", "motion", "off"]

FIELD_OF_VIEW: Final = 60.0
"""Horizontal, in degrees: assumed of endoscopes whose calibration is unknown."""

Deinterlacing = Literal["frame", "field", "off"]

StereoLayout = Literal["side-by-side", "top-bottom"]
"""How both eyes lie in one frame, the left one at the left or at the top."""
Stereo = Literal["auto", "off", StereoLayout]


def _read(given: object) -> object:
    """A file is what it says. Raises ValueError."""
    if not isinstance(given, Path):
        return given
    from renderer.readers.lenses.calibration_files import read_calibration

    try:
        return read_calibration(given)
    except ClipError as error:
        raise ClipError(spelled(str(error))) from error  # Pydantic takes no other text.


@dataclass(
    frozen=True,
    kw_only=True,
    config=ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True),
)
class ClipOptions:
    """How to read a clip where its files do not say. Options that a layout does not use are ignored.

    Raises:
        pydantic.ValidationError: (a ValueError) a value out of its range.

    Example:
        >>> from renderer import ClipOptions
        >>> ClipOptions(depth="brightness", frame_step=2).view_angle  # for open_clip(path, options)
        60.0
    """

    pose_convention: Literal["opencv", "opengl", "llff"] = "opencv"
    """Axes of the camera-to-world matrices of an EndoNeRF folder; all are equivalent for the identity poses
    of a fixed endoscope."""
    mask_polarity: Literal["auto", "tool", "tissue"] = "auto"
    """What the non-zero pixels of the masks mark. Auto: the layout's convention, for EndoNeRF tool; masks
    that look inverted are refused."""
    evaluation_masks: Literal["masks", "gt_masks"] = "masks"
    """Masks used for the metrics. The published figures use masks, which also leave out the pixels without
    stereo depth; gt_masks leave out the tools only."""
    bottom_rows: Annotated[int, Interval(ge=0, le=256), Unit("px")] | None = None
    """Rows of burned-in text at the bottom, not trained on; auto: detected."""
    field_of_view: Annotated[float, Interval(ge=5.0, le=170.0)] | None = None
    """Horizontal field of view in degrees, for images and videos without calibration. Auto: 60 are assumed,
    and found along with the poses where these come from the motion of the camera."""
    depth: DepthSource = "auto"
    """Where depth comes from: measured with the clip; matched between left and right images; or, without a
    scale, read from monocular maps beside the images, estimated from brightness, or found with the poses from
    the motion of the camera. Auto: the first of these that the clip has, but never an estimate."""
    baseline: Annotated[float, Interval(ge=0.01, le=1000.0), Unit("mm")] | None = None
    """Distance between the left and right camera, for stereo depth. Auto: from the calibration; without one,
    lengths are in units of the baseline."""
    frame_step: Annotated[int, Interval(ge=1, le=1000)] | None = None
    """Keep every n-th frame. Auto: all, and for SCARED the step usual for the dataset."""
    deinterlacing: Deinterlacing = "frame"
    """For interlaced video: one image per frame, one per field (twice as many), or off, as stored."""
    calibration: Annotated[Calibration | None, BeforeValidator(_read)] = None
    """The calibration of the lens or of both eyes, as OpenCV, ROS or Kalibr write it (YAML, XML, JSON),
    COLMAP's cameras.txt or StereoCalibration.ini: images are undistorted, pairs rectified, and stereo depth
    is in mm."""
    stereo: Stereo = "auto"
    """How the frames of a video hold both eyes, the left one first: side-by-side or top-bottom; off: they
    show one eye. Auto: as the video says."""
    bits: Annotated[int, Interval(ge=8, le=16)] | None = None
    """How many bits the values of 16-bit PNG and TIFF images use, alone or in a folder; they are shown over
    that range. Auto: 10 or 12, where these are enough and 8 are not; else, and for left and right images in
    two folders, 16, as stored."""
    alpha: Literal["mask", "ignored"] | None = None
    """What is fully transparent in images, alone or in a folder: outside the tissue (mask), or like any
    other pixel (ignored). Auto: mask."""
    split: Split = "field"
    """Frames held out of training: every eighth from the second on, as is usual, or the odd ones, as is usual
    for Hamlyn."""

    @property
    def view_angle(self) -> float:
        """The horizontal field of view in degrees, stated or assumed."""
        return FIELD_OF_VIEW if self.field_of_view is None else self.field_of_view

    @property
    def as_asked(self) -> ClipOptions:
        """The same without a lens that training found."""
        is_found = self.calibration is not None and self.calibration.found is not None
        return replace(self, calibration=None) if is_found else self

    def reads_as(self, other: ClipOptions) -> bool:
        """Whether training comes to read the same frames, whoever states the field of view, the bits or what
        alpha means, or finds a lens by which they are undistorted."""
        bits = self.bits if None not in (self.bits, other.bits) else other.bits
        alpha = self.alpha if None not in (self.alpha, other.alpha) else other.alpha
        asked = replace(self.as_asked, field_of_view=self.view_angle, bits=bits, alpha=alpha)
        return asked == replace(other.as_asked, field_of_view=other.view_angle)


DEFAULTS: Final = ClipOptions()
EVERY_OPTION: Final = tuple(ClipOptions.__dataclass_fields__)
"""Names of all options, for the flags."""
