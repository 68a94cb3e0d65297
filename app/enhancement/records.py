"""What enhanced pictures, videos of them and tuning sheets say of themselves."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from annotated_types import Interval
from pydantic import BeforeValidator, PlainSerializer
from pydantic.dataclasses import dataclass

from app.enhancement.contact_sheet import Undefined
from app.enhancement.measures import Lengths, MeasuredOver, Measures
from app.enhancement.methods import EnhancementSettings, RecordedSettings
from app.enhancement.settable import Pixels
from app.files.dicom.choices import DicomChoices
from app.files.image_files import ArrayImage
from app.files.provenance import plain
from app.files.records import LENIENT, Record, Source, Told
from enhance import FieldOfView, Statistics
from enhance.noise import NoiseCut
from enhance.result import Omission
from enhance.vessel import VesselParams
from renderer.readers.clip_options import Deinterlacing, Stereo
from renderer.readers.lenses.calibration import Calibration


def _numbers(given: Any) -> Any:
    """JSON says null for what could not be measured."""
    if not isinstance(given, dict):
        return given
    return {name: math.nan if value is None else value for name, value in given.items()}


def told_in_full(
    used: Statistics | None, pixels: Pixels, params: EnhancementSettings | None
) -> Statistics | None:
    """Those that `vessel` used for an image, where a record tells all that it looked for: another version may
    measure otherwise. None: to be measured, as of the paper's method always."""
    is_told = used is not None and (used.field is not None or pixels != "automatic")
    return used if is_told and isinstance(params, VesselParams) else None


Bits = Annotated[int, Interval(ge=8, le=16)]
RecordedMeasures = Annotated[Measures, BeforeValidator(_numbers)]


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class EnhancedPicture(Record):
    """One picture of a file, a folder or a video, enhanced."""

    kind: Literal["enhanced picture"] = "enhanced picture"
    source: Source
    output: str | None = None
    """The name of the file that holds it, where that is told elsewhere."""
    picture: str | None = None
    """Its name, without suffix."""
    frame: int | None
    """Of a video."""
    deinterlacing: Deinterlacing = "frame"
    stereo: Stereo = "auto"
    calibration: Calibration | None = None
    """By which it is undistorted; a pair is rectified."""
    bits: Bits = 16
    """That its 16-bit file uses; all, as always before 0.12.0, of images that do not say."""
    method: str
    params: RecordedSettings | None
    pixels: Pixels
    statistics: Statistics | None
    """Those used; of a whole series they are given, of the picture alone they are measured."""
    omitted: Annotated[tuple[Omission, ...] | None, Told] = None
    measures: Annotated[RecordedMeasures | None, Told] = None
    """Of a cell of a tuning grid."""
    dicom: DicomChoices | None = None
    """Of a DICOM object."""

    @property
    def pooled(self) -> Statistics | None:
        """The statistics that are those of more pictures than this one."""
        return self.statistics if self.statistics and self.statistics.scope != "image" else None

    @property
    def field(self) -> FieldOfView | None:
        """Within which it was made, where it was looked for in this picture alone and has been found: another
        version may find another."""
        if self.pixels != "automatic" or self.statistics is None or self.pooled is not None:
            return None
        return self.statistics.field

    @property
    def known(self) -> Statistics | None:
        """With which it is made: of `vessel`, also those of this picture alone, which another version may
        measure otherwise. None: to be measured."""
        return self.pooled or told_in_full(self.statistics, self.pixels, self.params)


Made = tuple[ArrayImage, EnhancedPicture]
"""An enhanced picture with what was used for it."""


def _in_short(pictures: tuple[EnhancedPicture, ...]) -> list[dict[str, Any]]:
    """As JSON: the first, and of each other only what differs from that, since there may be 200,000."""
    first = vars(pictures[0]) if pictures else {}
    others = (
        {name: value for name, value in vars(one).items() if value != first[name]} for one in pictures[1:]
    )
    return [*map(plain, pictures[:1]), *map(plain, others)]


def _in_full(given: Any) -> Any:
    """From JSON; one that says its kind is whole, as all are in records before 0.4.0."""
    if not isinstance(given, list) or not all(isinstance(one, dict) for one in given):
        return given
    return [one if "kind" in one else given[0] | one for one in given]


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class EnhancedVideo(Record):
    """Enhanced pictures as the frames of a video."""

    kind: Literal["enhanced video"] = "enhanced video"
    frames_per_second: float
    pictures: Annotated[tuple[EnhancedPicture, ...], BeforeValidator(_in_full), PlainSerializer(_in_short)]
    encoding: Annotated[str | None, Told] = None
    notices: Annotated[tuple[str, ...] | None, Told] = None
    dicom: DicomChoices | None = None
    """Of a DICOM object."""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class SheetCell(Record):
    """One setting of a tuning sheet."""

    label: str
    params: RecordedSettings


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class TuningSheet(Record):
    """The pictures of a tuning grid beside each other."""

    kind: Literal["tuning sheet"] = "tuning sheet"
    source: Source
    frame: int | None
    bits: Bits = 16
    """That its 16-bit file uses; all, as always before 0.12.0, of sheets that do not say."""
    method: str | None = None
    pixels: Pixels
    title: str
    columns: int
    breaks_labels: bool = False
    """Into as many lines as they need; False, as before 0.2.0: made as small as one line has room for."""
    measured_over: MeasuredOver = "whole image"
    """What its DV/BV is of; of sheets that do not say, the whole image."""
    noise_cut: NoiseCut = "by level"
    """Of its noise gains; by level, as before 0.4.0, of sheets that do not say."""
    lengths: Lengths = "in pixels"
    """That vessels are measured by; in pixels, as before 0.8.0, of sheets that do not say."""
    undefined: Undefined = "nan"
    """What it says of a measure that cannot be taken."""
    settings: tuple[SheetCell, ...]
