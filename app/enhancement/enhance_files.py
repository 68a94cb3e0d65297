"""An image, a folder of images or a video enhanced and written: all of it, with provenance, or nothing."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import chain, count
from pathlib import Path
from typing import Any, Final

from app.enhancement.dicom_files import is_dicom_name, require_dicom, write_dicom_film, write_enhanced_still
from app.enhancement.kept_inputs import require_own
from app.enhancement.methods import MethodEnhancer, Params, by_baseline, pool_for
from app.enhancement.recording import is_recording
from app.enhancement.records import EnhancedPicture, EnhancedVideo, Made
from app.enhancement.settable import POOLED_FRAMES, Pixels, Scope, drawn
from app.errors import UserError, sentence
from app.files.atomic import filled, together
from app.files.codecs import ending_of
from app.files.color_profiles import loses_profile, profile_of
from app.files.dicom.choices import DEIDENTIFIED, DicomChoices
from app.files.image_files import JPEGS, ArrayImage, is_image, write_image
from app.files.image_series import Series
from app.files.provenance import write_sidecar
from app.files.records import Source
from app.files.stepping import ahead, map_steps
from app.files.timing import Timing
from app.files.video import write_frames
from enhance import ImageError, Statistics
from enhance.image import BoolImage, full_scale, read_picture
from enhance.surround import DarkVotes, inside
from enhance.vessel import VesselParams
from renderer.clip import ClipError
from renderer.readers.clip_options import DEFAULTS, ClipOptions

STOPPED: Final = "stopped after"
"""How the notice of a video that is decoded in part begins, by which it is known."""

Tissue = Callable[[ArrayImage], BoolImage | None]
Stream = Generator[Any, None, None]
Measuring = Generator[None, None, Statistics | None]
Watch = Callable[[str, Sequence[str], Stream], Stream]
"""Passes the pictures of a stage on, "measure" or "enhance", of these names: where it is told how far that
is, or where they are made in advance."""


def unwatched(stage: str, names: Sequence[str], items: Stream) -> Stream:
    return items


@dataclass(frozen=True)
class Setting:
    """How all pictures are enhanced."""

    method: str
    params: Params
    statistics: Scope = "automatic"
    """Of each picture, or pooled over the series. Automatic: pooled of a recording, against flicker."""
    pixels: Pixels = "automatic"
    clip_options: ClipOptions = DEFAULTS
    """How videos are read."""
    dicom: DicomChoices = DEIDENTIFIED
    """Of a DICOM object that is written."""

    def pools(self, series: Series) -> bool:
        """Whether all pictures have the same statistics."""
        if self.statistics == "automatic":
            read = partial(_read, series)
            return self.params is not None and (series.is_video or is_recording(len(series), read))
        return self.statistics == "clip"


@dataclass(frozen=True)
class Unreadable:
    """A file of a folder that was passed over."""

    name: str
    reason: str


@dataclass(frozen=True)
class Written:
    """What has been made of one series."""

    pictures: tuple[EnhancedPicture, ...]
    """What was used for each."""
    notices: tuple[str, ...]
    """One sentence for each oddity and loss."""
    failed: tuple[Unreadable, ...] = ()
    """Of a folder, the images that could not be read; the others are written."""


def enhanced(record: EnhancedPicture, image: ArrayImage, enhancer: MethodEnhancer) -> Made:
    """Statistics of the picture alone are measured, unless they are told; those of all pictures together are
    taken over.

    Raises:
        ImageError: a picture that the paper's method or `vessel` cannot use.
        UserError: anything but 8-bit RGB for one of the other methods.
    """
    if record.params is None:
        return by_baseline(record.method, image), replace(record, statistics=None, omitted=())
    # `vessel` takes what is typical of each picture from that itself.
    is_measured = record.pooled is None or isinstance(record.params, VesselParams)
    mask = inside([image]) if is_measured and record.pixels == "tissue" else None
    enhancer.show(image, mask, record.field or drawn(record.pixels))
    result = enhancer.enhance(record.params, statistics=record.known)
    return result.image, replace(record, statistics=result.statistics, omitted=result.omitted)


def enhance_into(
    output: Path, series: Series, setting: Setting, watch: Watch = unwatched
) -> Generator[int, None, Written]:
    """Write a picture, a folder or a video; yields the number of pictures enhanced so far, and 0 after each
    that is measured before.

    What cannot be read of a folder is passed over. Closed before its end, it leaves nothing behind.

    Raises:
        UserError, ClipError: nothing that can be read, or what cannot be enhanced or written.
    """
    notices, failed = list(series.notices), dict[int, Unreadable]()
    pooled = yield from map_steps(pooled_statistics(series, setting, watch), lambda measured: 0)
    images = _pictures(series, notices, failed=failed)
    pictures = watch("enhance", series.names, _enhanced(series, ahead(images), setting, pooled))
    told = _told_of_losses(output, series, pictures, notices)
    try:
        if is_dicom_name(output):
            notices.extend(require_dicom(series.sources, setting.dicom))
            records = yield from _write_dicom(output, series, told, notices, setting.dicom)
        else:
            records = yield from _write(output, series, told, notices)
    finally:
        pictures.close()
    return Written(records, tuple(notices), tuple(failed.values()))


def _pictures(
    series: Series,
    notices: list[str],
    indices: Iterable[int] | None = None,
    failed: dict[int, Unreadable] | None = None,
) -> Stream:
    """The pictures, all or some, each with its number. A video that cannot be decoded to its end stops there,
    with a notice; of a folder, those that cannot be read are passed over, and are `failed`.

    Raises UserError, ClipError or OSError: none can be read.
    """
    first: Exception | None = None
    found = False
    for index in range(len(series)) if indices is None else indices:
        try:
            image = _read(series, index)
        except (UserError, ClipError, OSError) as error:
            if series.is_video and found:
                notice = f"{STOPPED} {index} of {len(series)} frames: {error}"
                notices.extend({notice}.difference(notices))
                return
            if series.is_video:
                raise
            first = first or error
            if failed is not None:
                failed[index] = Unreadable(series.sources[index].name, sentence(error))
        else:
            found = True
            yield index, image
    if first is not None and not found:
        raise first


def _read(series: Series, index: int) -> ArrayImage:
    """Raises UserError, ClipError or OSError: it cannot be read, or is no image, as an array with NaN."""
    image = series.read(index)
    try:
        read_picture(image)
    except ImageError as error:
        raise UserError(f"{error}: {series.sources[index]}") from error
    return image


def _tissue(series: Series, setting: Setting) -> Generator[None, None, Tissue]:
    """One mask for all pictures. Yields after each that is looked at."""
    if setting.pixels != "tissue":
        return lambda image: None
    _, first = next(_pictures(series, []))
    size, dark = first.shape[:2], DarkVotes()
    for _, image in _pictures(series, [], series.spread(POOLED_FRAMES)):
        if image.shape[:2] == size:
            dark.add(image)
        yield
    steady = dark.inside()
    return lambda image: steady if image.shape[:2] == size else inside([image])


def pooled_statistics(series: Series, setting: Setting, watch: Watch = unwatched) -> Measuring:
    """Of evenly spread pictures, the same as in the window; None: each has its own. Yields after each.

    Raises UserError: one is unusable.
    """
    look = setting.params
    if look is None or not setting.pools(series):
        return None
    pool = pool_for(look, drawn(setting.pixels))
    # What cannot be read is told where it is enhanced.
    measured = series.spread(POOLED_FRAMES)
    names = [series.names[index] for index in measured]
    try:
        tissue = yield from _tissue(series, setting)
        yield
        with closing(watch("measure", names, _pictures(series, [], measured))) as read:
            for _, image in read:
                pool.add(image, tissue(image))
                yield
        return pool.statistics()
    except ImageError as error:
        raise UserError(f"{error}: {series.sources[0].parent}") from error


def enhance_frame_into(
    output: Path, series: Series, index: int, setting: Setting
) -> Generator[None, None, EnhancedPicture]:
    """Write one of the pictures as a DICOM still; what was used for it. Yields after each that is measured.

    Raises:
        UserError, ClipError: no such picture, or one that cannot be enhanced or written.
    """
    if not 0 <= index < len(series):
        raise UserError(f"expected one of {len(series)} frames, got {index}")
    pooled = yield from pooled_statistics(series, setting)
    record = record_of(series, index, Source.of(series.sources[index]), setting, pooled)
    try:
        image, made = enhanced(record, series.read(index), MethodEnhancer())
    except ImageError as error:
        raise UserError(f"{error}: {series.sources[index]}") from error
    return write_enhanced_still(output, image, made, series.sources)


def record_of(
    series: Series, index: int, source: Source, setting: Setting, pooled: Statistics | None
) -> EnhancedPicture:
    """What is to be made of a picture."""
    return EnhancedPicture(
        source=source,
        picture=series.names[index],
        frame=series.frame(index),
        deinterlacing=setting.clip_options.deinterlacing,
        stereo=setting.clip_options.stereo,
        calibration=setting.clip_options.calibration,
        bits=series.bits,
        method=setting.method,
        params=setting.params,
        pixels="all" if setting.params is None else setting.pixels,
        statistics=pooled,
        dicom=setting.dicom if setting.dicom != DEIDENTIFIED else None,
    )


def _enhanced(series: Series, images: Stream, setting: Setting, pooled: Statistics | None) -> Stream:
    origin_of, enhancer = lru_cache(1)(Source.of), MethodEnhancer()
    try:
        for index, image in images:
            # Of a file that cannot be read there is no digest either.
            record = record_of(series, index, origin_of(series.sources[index]), setting, pooled)
            try:
                made = enhanced(record, image, enhancer)
            except (ImageError, UserError) as error:
                raise UserError(f"{error}: {series.sources[index]}") from error
            yield made
    finally:
        images.close()


def _told_of_losses(
    output: Path, series: Series, pictures: Iterable[Made], notices: list[str]
) -> Iterator[Made]:
    """The pictures, with a notice where their transparency, or the profile of the first, is lost."""
    is_film = ending_of(output) or is_dicom_name(output)
    is_opaque = (is_film or output.suffix.lower() in JPEGS) and not output.is_dir()
    is_file = (is_film or is_image(output)) and not output.is_dir()
    lost = f"which {output.suffix} does not hold"
    transparency = f"transparency is left out, {lost}"
    for place, (image, record) in enumerate(pictures):
        if is_opaque and transparency not in notices and _shows_through(image):
            notices.append(transparency)
        if place == 0 and is_file and loses_profile(output, series.files[0], image):
            notices.append(f"the ICC profile of the colours is left out, {lost}: they are shown as sRGB")
        yield image, record


def _shows_through(image: ArrayImage) -> bool:
    """Whether some alpha is below full, as is none of a screenshot's."""
    return image.shape[2:] == (4,) and bool((image[..., 3] < full_scale(image.dtype)).any())


def _write(
    output: Path, series: Series, pictures: Iterator[Made], notices: list[str]
) -> Generator[int, None, tuple[EnhancedPicture, ...]]:
    """Write all pictures or none; what was used for each."""
    if ending_of(output):
        with together(output) as place:
            video = yield from write_enhanced_video(place, pictures, series.timing, notices)
        return video.pictures
    if is_image(output) and not output.is_dir():
        ((image, record),) = pictures
        write_image(output, image, record.signed, profile=profile_of(series.files[0], image))
        yield 1
        return (replace(record, output=output.name),)
    written, files = list[EnhancedPicture](), dict(zip(series.names, series.files, strict=True))
    with filled(output) as staging:
        for image, record in pictures:
            # PNG holds no floats.
            suffix = ".tiff" if image.dtype.kind == "f" else ".png"
            if not written:  # What is taken by another program is told before all the work is done.
                require_own(*(output / f"{name}{suffix}" for name in files))
            name = _free(staging, record.picture or "", suffix)
            require_own(output / name)
            profile = profile_of(files[record.picture or ""], image)
            write_image(staging / name, image, record.signed, profile=profile)
            written.append(replace(record, output=name))
            yield len(written)
    return tuple(written)


def _free(folder: Path, stem: str, suffix: str) -> str:
    """A name that is not there: of A.png and a.png, some disks keep one."""
    names = chain((stem,), (f"{stem}-{number}" for number in count(2)))
    return next(name for own in names if not (folder / (name := f"{own}{suffix}")).exists())


def _write_dicom(
    output: Path, series: Series, pictures: Iterator[Made], notices: list[str], choices: DicomChoices
) -> Generator[int, None, tuple[EnhancedPicture, ...]]:
    """One object: a still of one picture, else a video."""
    if not series.is_video and len(series) == 1:
        ((image, record),) = pictures
        record = write_enhanced_still(output, image, record, series.sources)
        yield 1
        return (replace(record, output=output.name),)
    film = write_dicom_film(output, pictures, series.timing, notices, choices, series.sources)
    return (yield from film).pictures


def write_enhanced_video(
    place: Path, pictures: Iterable[Made], timing: Timing, notices: list[str]
) -> Generator[int, None, EnhancedVideo]:
    """The video, and beside it its record, which this container does not carry."""
    records: list[EnhancedPicture] = []

    def frames() -> Iterator[ArrayImage]:
        for image, record in pictures:
            records.append(replace(record, output=place.name))
            yield image

    written = yield from write_frames(place, frames(), timing)
    notices.extend(written.notices)
    video = EnhancedVideo(
        frames_per_second=timing.frames_per_second,
        pictures=tuple(records),
        encoding=written.encoding,
        notices=tuple(notices),
    )
    write_sidecar(place, video.signed)
    return video
