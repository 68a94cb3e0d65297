"""DICOM objects on disk: a still as it is, a video as the file that holds it, and the record in either."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from app.errors import UserError
from app.files.atomic import replaced
from app.files.dicom.choices import DicomChoices
from app.files.dicom.labels import CREATOR, GROUP, Kind, code, labelled
from app.files.dicom.sources import Sources
from app.files.image_files import ArrayImage, wide_formats
from app.files.provenance import ascii_json
from app.files.timing import Timing
from renderer.clip import ClipError
from renderer.readers.dicom.header import read_dataset
from renderer.readers.dicom.opening import NO_PYDICOM, has_pydicom, opened_dicom
from renderer.readers.video_header import read_video_header

if TYPE_CHECKING:
    from pydicom import Dataset

H264_LEVELS: Final = (("1.2.840.10008.1.2.4.102", 8192, 245_760), ("1.2.840.10008.1.2.4.104", 8704, 522_240))
"""Transfer syntaxes of the High profile at levels 4.1 and 4.2; blocks of 16x16 pixels of a frame, and in a
second (ITU-T H.264, table A-1)."""
LARGEST: Final = 2**32 - 2
"""Bytes of a video that is one fragment."""
LONGEST: Final = 2**16 - 2
"""Characters of all frame times."""
METHOD: Final = "ISO_14496_10"


@dataclass(frozen=True, eq=False)
class Derived:
    """What a written object says of where it comes from."""

    sources: Sources
    choices: DicomChoices
    description: str
    """Of the settings, in words."""

    def labels(self, kind: Kind, facts: dict[str, Any]) -> Dataset:
        return labelled(kind, self.sources, self.choices, self.description, ascii_json(facts))


def require_pydicom() -> None:
    """Raises UserError."""
    if not has_pydicom():
        raise UserError(NO_PYDICOM)


def write_dicom_still(path: Path, image: ArrayImage, facts: dict[str, Any], derived: Derived) -> None:
    """(H, W) grey, (H, W, 3) RGB, or (H, W, 4) RGBA, whose alpha is lost; of 8 bits, as the standard has it.

    Raises:
        UserError: values of another type, no pydicom, or no identity to keep.
    """
    require_pydicom()
    if image.dtype != np.uint8:
        named = f"{path.suffix} holds 8 bits a value, not {image.dtype}"
        raise UserError(f"{named}; name the output {wide_formats(image)}: {path}")
    pixels = np.ascontiguousarray(image[..., :3] if image.ndim == 3 else image)
    with replaced(path) as place, quiet():
        made = derived.labels("still", facts)
        made.Rows, made.Columns = pixels.shape[:2]
        _of_bytes(made, 1 if pixels.ndim == 2 else 3, "MONOCHROME2" if pixels.ndim == 2 else "RGB")
        made.PixelData = pixels.tobytes() + bytes(pixels.size % 2)
        made["PixelData"].VR = "OB"
        made.save_as(place, enforce_file_format=True)


def require_level(size: tuple[int, int], frames_per_second: float, path: Path) -> str:
    """The transfer syntax of a video of that size. Raises UserError: DICOM has none."""
    blocks = -(-size[0] // 16) * -(-size[1] // 16)
    for syntax, most, most_a_second in H264_LEVELS:
        if blocks <= most and blocks * frames_per_second <= most_a_second:
            return syntax
    got = f"{size[0]}x{size[1]} at {frames_per_second:.4g}"
    raise UserError(
        f"expected at most 1920x1088 at 64 frames a second for H.264 in DICOM, got {got} "
        f"(name the output .mp4): {path}"
    )


def write_dicom_video(
    place: Path, video: Path, frames: int, timing: Timing, facts: dict[str, Any], derived: Derived
) -> None:
    """`video`, an .mp4 of H.264, as it is: it is copied piece by piece.

    Raises:
        UserError: it is too large or too long, or no identity to keep.
    """
    from pydicom.encaps import encapsulate_buffer
    from pydicom.uid import UID

    length, told = video.stat().st_size, read_video_header(video)
    if length > LARGEST:
        raise UserError(f"expected at most {LARGEST} bytes of video in DICOM, got {length}: {place}")
    with quiet(), video.open("rb") as content:
        made = derived.labels("video", facts)
        made.file_meta.TransferSyntaxUID = UID(require_level(told.size, timing.frames_per_second, place))
        made.Columns, made.Rows = told.size
        _of_bytes(made, 3, "YBR_PARTIAL_420")
        _timed(made, frames, timing)
        if told.pixel_aspect != 1:
            shape = Fraction(told.pixel_aspect).limit_denominator(1000)
            made.PixelAspectRatio = [shape.denominator, shape.numerator]
        made.LossyImageCompression, made.LossyImageCompressionMethod = "01", METHOD
        made.LossyImageCompressionRatio = f"{frames * told.size[0] * told.size[1] * 3 / length:.2f}"
        if told.sound is not None:
            made.MultiplexedAudioChannelsDescriptionCodeSequence = [_sound(video)]
        made.PixelData = encapsulate_buffer([content], has_bot=False)
        made["PixelData"].VR = "OB"
        made["PixelData"].is_undefined_length = True
        made.save_as(place, enforce_file_format=True)


def _sound(video: Path) -> Dataset:
    """The item that describes the audio track of the video."""
    from pydicom import Dataset

    from app.files.sound import named_layout
    from renderer.readers.video_decoding.video_index import open_container

    with open_container(video) as container:
        layout = named_layout(container.streams.audio[0].codec_context)
    track = Dataset()
    track.ChannelIdentificationCode, track.ChannelMode = 1, "MONO" if layout == "mono" else "STEREO"
    track.ChannelSourceSequence = [code("109112", "Ambient room environment")]
    return track


def _of_bytes(made: Dataset, samples: int, photometric: str) -> None:
    made.SamplesPerPixel, made.PhotometricInterpretation = samples, photometric
    made.BitsAllocated, made.BitsStored, made.HighBit, made.PixelRepresentation = 8, 8, 7, 0
    if samples == 3:
        made.PlanarConfiguration = 0


def _timed(made: Dataset, frames: int, timing: Timing) -> None:
    """Frame times as one, or as a list where they differ and the list has room; the video has them anyway."""
    rate = timing.frames_per_second
    made.NumberOfFrames = frames
    made.CineRate = made.RecommendedDisplayFrameRate = max(round(rate), 1)
    if timing.frame_times is not None:
        steps = ["0", *(f"{1000 * (later - one):.6g}" for one, later in pairwise(timing.frame_times))]
        if len("\\".join(steps)) <= LONGEST:
            made.FrameIncrementPointer = 0x00181065
            made.FrameTimeVector = steps
            return
    made.FrameIncrementPointer = 0x00181063
    made.FrameTime = f"{1000 / rate:.6g}"


@contextmanager
def quiet() -> Iterator[None]:
    """A source may break rules of its own, which are taken over with its identity. Raises OSError as the
    system does: pydicom tells it as a text without its number."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            yield
        except OSError as error:
            raise (error if error.errno else error.__cause__ or error) from None


def facts_in_dicom(path: Path) -> str | None:
    """The record in an object of ours, as JSON. Raises UserError: it is damaged, or pydicom is missing."""
    try:
        with opened_dicom(path) as file:
            told = read_dataset(file, path, ((GROUP, 0x0010), (GROUP, 0x1001)))
            if str(told.get((GROUP, 0x0010), "")) and told[GROUP, 0x0010].value == CREATOR:
                return str(told[GROUP, 0x1001].value)
            return None
    except ClipError as error:
        raise UserError(str(error)) from error
