"""Enhanced pictures and videos as DICOM objects."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from dataclasses import replace
from pathlib import Path, PurePath
from typing import Final

from app.enhancement.records import EnhancedPicture, EnhancedVideo, Made
from app.enhancement.setting_words import worded
from app.errors import UserError
from app.files.atomic import together, told_as
from app.files.dicom.choices import DEIDENTIFIED, DicomChoices
from app.files.dicom.labels import may_tell
from app.files.dicom.sources import sources_of
from app.files.dicom.writing import (
    Derived,
    require_level,
    require_pydicom,
    write_dicom_still,
    write_dicom_video,
)
from app.files.image_files import ArrayImage
from app.files.provenance import version
from app.files.records import Source
from app.files.timing import Timing
from app.files.video import write_frames
from app.files.video_encoder import video_encoder
from renderer.readers.dicom.opening import SUFFIXES
from renderer.readers.video_header import read_video_header

MAY_TELL: Final = (
    "the images are not searched for text: the DICOM file states that some may tell who the patient is "
    "(--burned-in no states that there is none)"
)
SILENT: Final = "the sound is left out, since speech may tell who the patient is (--keep-identity keeps it)"


def is_dicom_name(path: Path) -> bool:
    return path.suffix.lower() in SUFFIXES


def require_dicom(sources: Iterable[Path], choices: DicomChoices) -> tuple[str, ...]:
    """What is to be said beside a DICOM object that will be made of these files.

    Raises UserError: no pydicom, or no identity to keep.
    """
    require_pydicom()
    found = sources_of(sources)
    if choices.keep_identity:
        found.require_identity()
    return (MAY_TELL,) if may_tell(found, choices) and not choices.keep_identity else ()


def write_enhanced_still(
    path: Path, image: ArrayImage, record: EnhancedPicture, sources: Iterable[Path]
) -> EnhancedPicture:
    """What the object says of itself. Raises UserError as `write_dicom_still`."""
    choices = record.dicom or DEIDENTIFIED
    said = _unnamed(replace(record, dicom=choices))
    derived = Derived(sources_of(sources), choices, _described(said))
    write_dicom_still(path, image, said.signed, derived)
    return said


def write_dicom_film(
    path: Path,
    pictures: Iterable[Made],
    timing: Timing,
    notices: list[str],
    choices: DicomChoices,
    sources: tuple[Path, ...],
) -> Generator[int, None, EnhancedVideo]:
    """Encoded as any video, then put into the object; yields the number of frames written.

    Raises UserError: no encoder of H.264, no pydicom, no identity to keep, or what DICOM has no room for.
    """
    require_pydicom()
    encoder = video_encoder()
    if not encoder.plays_in_browsers:
        raise UserError(f"a DICOM video is H.264, which cannot be encoded here. {encoder.way_out}")
    with together(path) as place:
        # Whatever the object is called: an ending such as .hevc would ask for another codec.
        video = place.with_name("film.mp4")
        records = list[EnhancedPicture]()
        timing = timing if choices.keep_identity else _silent(timing, notices)
        frames = _checked(pictures, records, timing, path)
        with told_as(path, video):
            written = yield from write_frames(video, frames, timing)
        notices.extend(written.notices)
        made = EnhancedVideo(
            frames_per_second=timing.frames_per_second,
            pictures=tuple(_unnamed(replace(each, output=path.name, dicom=choices)) for each in records),
            encoding=written.encoding,
            notices=tuple(notices) if choices.keep_identity else None,  # They may name files.
            dicom=choices,
        )
        derived = Derived(sources_of(sources), choices, _described(made.pictures[0]))
        write_dicom_video(place, video, len(records), timing, made.signed, derived)
        video.unlink()
    return made


def _checked(
    pictures: Iterable[Made], records: list[EnhancedPicture], timing: Timing, path: Path
) -> Iterator[ArrayImage]:
    """The pictures, of which the first tells whether DICOM has room for such a video."""
    for image, record in pictures:
        if not records:
            require_level((image.shape[1], image.shape[0]), timing.frames_per_second, path)
        records.append(record)
        yield image


def _silent(timing: Timing, notices: list[str]) -> Timing:
    if timing.like is not None and read_video_header(timing.like).sound is not None:
        notices.append(SILENT)
    return replace(timing, has_sound=False)


def _unnamed(record: EnhancedPicture) -> EnhancedPicture:
    """Files are often named after patients."""
    if record.dicom is None or record.dicom.keep_identity:
        return record
    source = Source(name=f"source{PurePath(record.source.name).suffix}", sha256=record.source.sha256)
    picture = record.picture if record.frame is not None else "source"
    return replace(record, source=source, picture=picture)


def _described(record: EnhancedPicture) -> str:
    look = "" if record.params is None else f": {worded(record.params, record.statistics)}"
    scope = "" if record.statistics is None else f"; statistics of the {record.statistics.scope}"
    return f"Vessels made visible by VesselSplat {version()}, method {record.method}{look}{scope}"
