"""An image, a folder of images or a video enhanced and written: all of it, with provenance, or nothing."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import tee
from pathlib import Path
from typing import Any, Literal

from app.enhancement.methods import Enhanced, MethodEnhancer, Params, apply, measure_for
from app.errors import UserError
from app.files.atomic import filled, together
from app.files.image_files import ArrayImage, is_image, write_image
from app.files.image_series import Series
from app.files.prefetch import ahead
from app.files.provenance import provenance, write_sidecar
from app.files.video import write_frames
from enhance import ImageError, Statistics
from enhance.image import BoolImage
from enhance.surround import inside
from renderer.clip import ClipError
from renderer.readers.clip_options import DEFAULTS, ClipOptions

VIDEO = ".mp4"
STEADY_FRAMES = 16
"""Evenly spread pictures that tell the surround of all."""

Facts = dict[str, Any]
Tissue = Callable[[ArrayImage], BoolImage | None]
Stream = Generator[Any, None, None]
Watch = Callable[[str, Series, Stream], Stream]
"""Passes the pictures of a stage on, "measure" or "enhance": where it is told how far that is, or where they
are made in advance."""


def unwatched(stage: str, series: Series, items: Stream) -> Stream:
    return items


@dataclass(frozen=True)
class Setting:
    """How all pictures are enhanced."""

    method: str
    params: Params
    statistics: Literal["image", "clip"] = "image"
    """Of each picture, or pooled over the series."""
    pixels: Literal["all", "tissue"] = "all"
    """Which of them count in the statistics; "tissue" leaves out the black surround."""
    pooled: int | None = None
    """Evenly spread pictures whose statistics stand for a series; None: all of them."""
    clip_options: ClipOptions = DEFAULTS
    """How videos are read."""

    @property
    def facts(self) -> Facts:
        return {"method": self.method, "params": self.params, "pixels": self.pixels}


@dataclass(frozen=True)
class Written:
    """What has been made of one series."""

    pictures: tuple[Facts, ...]
    """What was used for each."""
    notices: tuple[str, ...]
    """One sentence for each oddity and loss."""


@dataclass(frozen=True, eq=False)
class _Job:
    setting: Setting
    tissue: Tissue
    """Which pixels count, as a mask; None: all."""
    statistics: Statistics | None = None
    """Of the whole series; None: of each picture."""


@dataclass(frozen=True, eq=False)
class _Picture:
    name: str
    source: dict[str, str]
    frame: int | None
    """Of a video."""
    job: _Job
    result: Enhanced

    @property
    def facts(self) -> Facts:
        return {
            "kind": "enhanced picture",
            "source": self.source,
            "picture": self.name,
            "frame": self.frame,
            "deinterlacing": self.job.setting.clip_options.deinterlacing,
            **self.job.setting.facts,
            "statistics": self.result.statistics,
            "omitted": self.result.omitted,
        }


def enhance_into(
    output: Path, series: Series, setting: Setting, watch: Watch = unwatched
) -> Generator[int, None, Written]:
    """Write a picture, a folder or a video; yields the number of pictures enhanced so far.

    Closed before its end, it leaves nothing behind.

    Raises:
        UserError, ClipError: what cannot be read, enhanced or written.
    """
    notices = list(series.notices)
    job = _Job(setting, _tissue(series, setting))
    if setting.statistics == "clip":
        job = replace(job, statistics=_pooled(series, job, notices, watch))
    pictures = watch("enhance", series, _enhanced(series, ahead(_pictures(series, notices)), job))
    try:
        facts = yield from _write(output, series, pictures, notices)
    finally:
        pictures.close()
    return Written(tuple(facts), tuple(notices))


def _pictures(series: Series, notices: list[str], indices: Iterable[int] | None = None) -> Stream:
    """The pictures, all or some. A video that cannot be decoded to its end stops there, with a notice."""
    for index in range(len(series)) if indices is None else indices:
        try:
            image = series.read(index)
        except ClipError as error:
            if index == 0 or not series.is_video:
                raise
            notice = f"stopped after {index} of {len(series)} frames: {error}"
            notices.extend({notice}.difference(notices))
            return
        yield image


def _tissue(series: Series, setting: Setting) -> Tissue:
    """Of each picture on its own, or where the statistics are those of all pictures, one mask for all."""
    if setting.pixels == "all":
        return lambda image: None
    if setting.statistics == "image":
        return lambda image: inside([image])
    size = series.read(0).shape[:2]
    spread = _pictures(series, [], series.spread(STEADY_FRAMES))
    try:
        steady = inside(image for image in spread if image.shape[:2] == size)
    except ImageError as error:
        raise UserError(f"{error}: {series.sources[0].parent}") from error
    return lambda image: steady if image.shape[:2] == size else inside([image])


def _pooled(series: Series, job: _Job, notices: list[str], watch: Watch) -> Statistics:
    look, pooled = job.setting.params, job.setting.pooled
    assert look is not None
    indices = None if pooled is None else series.spread(pooled)
    # Both iterables of `measure_for` walk the same pictures in step: each is decoded once and let go.
    images, again = tee(watch("measure", series, _pictures(series, notices, indices)))
    try:
        return measure_for(look, images, map(job.tissue, again))
    except ImageError as error:
        raise UserError(f"{error}: {series.sources[0].parent}") from error


def _enhanced(series: Series, images: Stream, job: _Job) -> Stream:
    origins, enhancer, setting = series.origins(), MethodEnhancer(), job.setting
    try:
        for index, image in enumerate(images):
            try:
                mask = job.tissue(image) if job.statistics is None else None
                result = apply(setting.method, setting.params, image, mask, job.statistics, enhancer)
            except (ImageError, UserError) as error:
                raise UserError(f"{error}: {series.sources[index]}") from error
            yield _Picture(series.names[index], next(origins), series.frame(index), job, result)
    finally:
        images.close()


def _write(
    output: Path, series: Series, pictures: Iterator[_Picture], notices: list[str]
) -> Generator[int, None, list[Facts]]:
    """Write all pictures or none; what was used for each."""
    if output.suffix.lower() == VIDEO:
        return (yield from _write_video(output, series, pictures, notices))
    if is_image(output) and not output.is_dir():
        (picture,) = pictures
        write_image(output, picture.result.image, provenance(**picture.facts))
        yield 1
        return [{"output": output.name} | picture.facts]
    facts: list[Facts] = []
    with filled(output) as staging:
        for picture in pictures:
            image = picture.result.image
            # PNG holds no floats.
            name = picture.name + (".tiff" if image.dtype.kind == "f" else ".png")
            write_image(staging / name, image, provenance(**picture.facts))
            facts.append({"output": name} | picture.facts)
            yield len(facts)
    return facts


def _write_video(
    output: Path, series: Series, pictures: Iterator[_Picture], notices: list[str]
) -> Generator[int, None, list[Facts]]:
    """The video, and beside it its provenance, which this container does not carry."""
    facts: list[Facts] = []

    def frames() -> Iterator[ArrayImage]:
        for picture in pictures:
            facts.append({"output": output.name} | picture.facts)
            yield picture.result.image

    with together(output) as place:
        written = yield from write_frames(place, frames(), series.timing)
        notices.extend(written.notices)
        record = {
            "kind": "enhanced video",
            "frames_per_second": series.timing.frames_per_second,
            "pictures": facts,
        }
        write_sidecar(place, provenance(**record, encoding=written.encoding, notices=notices))
    return facts
