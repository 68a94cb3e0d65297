"""What a DICOM object says of its pictures, without decoding any."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from renderer.budget import OverBudget, budget
from renderer.clip import ClipError
from renderer.readers.dicom.opening import is_dicom, opened_dicom

if TYPE_CHECKING:
    from pydicom import Dataset

VIDEO_STREAMS: Final = re.compile(r"1\.2\.840\.10008\.1\.2\.4\.10\d(\.1)?")
"""Transfer syntaxes of MPEG-2, H.264 and H.265."""
DEFLATED: Final = "1.2.840.10008.1.2.1.99"
TAGS: Final = (
    "SOPClassUID", "BurnedInAnnotation", "LossyImageCompression",
    "FrameTime", "FrameTimeVector", "CineRate", "RecommendedDisplayFrameRate",
    "SamplesPerPixel", "PhotometricInterpretation", "NumberOfFrames", "Rows", "Columns",
    "PixelAspectRatio", "BitsAllocated", "BitsStored", "PixelRepresentation",
)  # fmt: skip
Tags = Sequence[str] | Sequence[tuple[int, int]]
"""By name, or by number."""
FASTEST: Final = 1000.0
"""Frames a second."""


Kind = Literal["image", "clip", "none"]
"""One frame; several, or a video; a report, a directory and the like. What is damaged counts as an image."""


class NoImage(ClipError):
    """An object is intact, and of a kind that has no image."""


@dataclass(frozen=True)
class DicomHeader:
    """Of the pictures of an object."""

    transfer_syntax: str
    """Its UID."""
    is_encapsulated: bool
    """Whether frames are compressed, each in fragments of its own."""
    size: tuple[int, int]
    """Width and height in pixels."""
    frames: int
    samples: int
    """Of a pixel: 1 or 3."""
    bits_allocated: int
    bits_stored: int
    is_signed: bool
    photometric: str
    pixel_aspect: float
    """Width of a pixel by its height."""
    frames_per_second: float | None
    frame_times: tuple[float, ...] | None
    """Seconds from the first frame, where frames do not come evenly."""
    pixels_at: int
    """Where in the file the element of the pixels begins."""

    @property
    def is_stream(self) -> bool:
        """Whether its pixels are a video as a file of its own, not frames."""
        return VIDEO_STREAMS.fullmatch(self.transfer_syntax) is not None

    @property
    def moves(self) -> bool:
        return self.is_stream or self.frames > 1


def read_header(path: Path) -> DicomHeader:
    """Raises ClipError: pydicom is missing, the header is damaged, or it announces no picture."""
    with opened_dicom(path) as file:
        found = _header(file, path)
        try:
            budget().require(pixels=found.size[0] * found.size[1], frames=found.frames)
        except OverBudget as error:
            raise ClipError(f"{error}: {path}") from error
        return found


def dicom_kind(path: Path) -> Kind | None:
    """What a file of any name holds; None: it is not DICOM."""
    if not is_dicom(path):
        return None
    try:
        return "clip" if read_header(path).moves else "image"
    except NoImage:
        return "none"
    except ClipError:
        return "image"  # Whoever opens it says what is wrong.


def holds_stream(path: Path) -> bool:
    """Whether a video file is one as such: frames of a DICOM object have neither sound nor colour tags."""
    return not is_dicom(path) or read_header(path).is_stream


def read_dataset(file: io.BufferedReader, path: Path, tags: Tags | None = None) -> Dataset:
    """All but the pixels, or of that those tags alone; `file` stands where the pixels begin then.

    Raises ClipError: the object is packed as a whole, which may unpack to any size. Else what pydicom raises.
    """
    from pydicom import dcmread
    from pydicom.filereader import read_file_meta_info

    if str(read_file_meta_info(path).get("TransferSyntaxUID", "")) == DEFLATED:
        raise ClipError(f"expected a DICOM file that is not deflated (dcmconv +te unpacks it): {path}")
    wanted: Any = None if tags is None else list(tags)
    return dcmread(file, stop_before_pixels=True, specific_tags=wanted)


def _header(file: io.BufferedReader, path: Path) -> DicomHeader:
    told = read_dataset(file, path, TAGS)
    at, length = file.tell(), file.seek(0, io.SEEK_END)
    rows, columns = _whole(told, "Rows", 0), _whole(told, "Columns", 0)
    if rows < 1 or columns < 1 or length - at < 8:
        what = told.get("SOPClassUID")
        kind = f" of {what.name}" if what is not None and what.name else ""
        raise NoImage(f"expected a DICOM file with an image, got one{kind} without: {path}")
    bits, syntax = _whole(told, "BitsAllocated", 8), told.file_meta.TransferSyntaxUID
    return DicomHeader(
        transfer_syntax=str(syntax),
        is_encapsulated=syntax.is_encapsulated,
        size=(columns, rows),
        frames=max(_whole(told, "NumberOfFrames", 1), 1),
        samples=_whole(told, "SamplesPerPixel", 1),
        bits_allocated=bits,
        bits_stored=_whole(told, "BitsStored", bits),
        is_signed=_whole(told, "PixelRepresentation", 0) == 1,
        photometric=str(told.get("PhotometricInterpretation", "")),
        pixel_aspect=_aspect(told),
        frames_per_second=_rate(told),
        frame_times=_times(told),
        pixels_at=at,
    )


def _whole(told: Dataset, name: str, usual: int) -> int:
    """Raises ValueError: it is no number."""
    value = told.get(name)
    return usual if value in (None, "") else int(value)


def _positive(value: Any) -> float | None:
    """None for what is no number, or none that time or shape can have."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        return None
    return number if number > 0 and isfinite(number) else None


def _rate(told: Dataset) -> float | None:
    """By the first of the elements that makes sense."""
    lasting = _positive(told.get("FrameTime"))
    rates = (
        lasting and 1000 / lasting,
        _positive(told.get("CineRate")),
        _positive(told.get("RecommendedDisplayFrameRate")),
    )
    return next((rate for rate in rates if rate is not None and rate < FASTEST), None)


def _times(told: Dataset) -> tuple[float, ...] | None:
    """Of a vector with milliseconds from frame to frame, the first of which counts from nothing."""
    vector = told.get("FrameTimeVector")
    if not isinstance(vector, Sequence) or isinstance(vector, str) or len(vector) < 2:
        return None
    steps = [_positive(step) for step in vector[1:]]
    whole = [step for step in steps if step is not None]
    return (
        tuple(accumulate((step / 1000 for step in whole), initial=0.0)) if len(whole) == len(steps) else None
    )


def _aspect(told: Dataset) -> float:
    """Told as height, then width."""
    pair = told.get("PixelAspectRatio")
    if not isinstance(pair, Sequence) or isinstance(pair, str) or len(pair) != 2:
        return 1.0
    height, width = map(_positive, pair)
    return width / height if width and height else 1.0
