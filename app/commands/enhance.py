"""`vesselsplat enhance INPUT OUTPUT`: pictures in, enhanced pictures out."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, replace
from itertools import tee
from pathlib import Path
from typing import Any, TypeVar, cast

from app.ahead import ahead
from app.arguments import add_fields, parameters
from app.atomic import filled
from app.errors import UserError
from app.methods import METHODS, PAPER, VESSEL, Enhanced, LookEnhancer, Params, apply, measure_for
from app.pictures import ArrayImage, is_image, write_image
from app.progress import progress
from app.provenance import provenance, strict_json, write_sidecar
from app.series import Series, open_series
from app.video import write_video
from enhance import EnhanceParams, ImageError, Statistics
from enhance.image import BoolImage
from enhance.surround import inside
from enhance.vessel import VesselParams
from renderer.clip import ClipError

FIELDS = ("z", "p", "radii", "eps", "subsample", "d_factor", "keep_black", "omit_below")
VESSEL_FIELDS = ("strength", "radius", "shading", "coring", "lift", "gamma", "most_color")
OWN_FIELDS = {PAPER: set(FIELDS), VESSEL: {*VESSEL_FIELDS, "d_factor"}}
VIDEO = ".mp4"
VIDEOS = frozenset({".avi", ".m4v", ".mkv", ".mov", ".mpeg", ".mpg", ".mts", ".ogv", ".webm", ".wmv"})
PICTURES = frozenset({".avif", ".dcm", ".exr", ".gif", ".heic", ".jp2", ".jxl", ".psd", ".svg"})
NOT_WRITTEN = VIDEOS | PICTURES
"""Formats that are not written; any other name, such as 2024.05.01, is that of a folder."""

STEADY_FRAMES = 16
"""Evenly spread pictures that tell the surround of all."""

T = TypeVar("T")
Tissue = Callable[[ArrayImage], BoolImage | None]


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("input", metavar="INPUT", type=Path, help="picture, folder of pictures or video")
    parser.add_argument("output", metavar="OUTPUT", type=Path, help="picture, folder or .mp4 video to write")
    parser.add_argument(
        "--method",
        choices=METHODS,
        default=PAPER,
        help="the paper's method (default), the own preset `vessel`, or another one to compare with",
    )
    add_fields(parser, EnhanceParams, FIELDS)
    group = parser.add_argument_group("with --method vessel", "and --d-factor, which is 0.5 there")
    add_fields(cast(argparse.ArgumentParser, group), VesselParams, VESSEL_FIELDS)
    parser.add_argument(
        "--statistics",
        choices=("image", "clip"),
        default="image",
        help="measure each picture on its own, or all together so that colours agree (default image)",
    )
    parser.add_argument(
        "--pixels",
        choices=("all", "tissue"),
        default="all",
        help="measure every pixel as the paper does, or leave out the black surround (default all)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def run(flags: argparse.Namespace) -> None:
    params = _params(flags)
    series = open_series(flags.input)
    _check_output(flags.input, flags.output, series)
    started = time.perf_counter()
    notices = list(series.notices)
    job = _Job(flags.method, params, flags.pixels, _tissue(series, flags))
    if flags.statistics == "clip":
        job = replace(job, statistics=_pooled(series, job, notices))
    pictures = ahead(_enhanced(series, ahead(_pictures(series, notices)), job))
    written = _write(flags.output, series, _told("enhance", series, pictures), notices)
    shared = {"method": flags.method, "params": params, "pixels": flags.pixels, "notices": notices}
    for notice in notices:
        sys.stderr.write(f"{notice}\n")
    seconds = time.perf_counter() - started
    if flags.json:
        sys.stdout.write(strict_json(provenance(**shared, pictures=written, seconds=seconds)) + "\n")
    else:
        sys.stdout.write(f"{flags.output}: {len(written)} enhanced in {seconds:.1f} s\n")


def _params(flags: argparse.Namespace) -> Params:
    """Of the method asked for. Raises UserError when flags of another one are given."""
    for name in (*FIELDS, *VESSEL_FIELDS):
        if name in flags and name not in OWN_FIELDS.get(flags.method, set()):
            raise UserError(f"--{name.replace('_', '-')} does nothing with --method {flags.method}")
    if flags.method == PAPER:
        return parameters(EnhanceParams, flags)
    if flags.method == VESSEL:
        return parameters(VesselParams, flags)
    for name, value in (("statistics", "clip"), ("pixels", "tissue")):
        if getattr(flags, name) == value:
            raise UserError(f"--{name} {value} does nothing with --method {flags.method}")
    return None


def _check_output(given: Path, output: Path, series: Series) -> None:
    """Refuse what would overwrite the input, or has no place for what comes."""
    files = {path.resolve() for path in series.sources}
    taken = {given.resolve(), *files, *((path.parent for path in files) if given.is_dir() else ())}
    if output.resolve() in taken or (output.is_dir() and output.resolve() in {path.parent for path in files}):
        raise UserError(f"expected another OUTPUT than INPUT, which is never overwritten: {output}")
    if is_image(output) and len(series) > 1:
        raise UserError(f"expected a folder or {VIDEO} for {len(series)} pictures, got {output}")
    if output.suffix.lower() in NOT_WRITTEN and not output.is_dir():
        raise UserError(f"expected a picture, a folder or {VIDEO} to write, got {output}")


@dataclass(frozen=True, eq=False)
class _Job:
    method: str
    params: Params
    pixels: str
    """Which of them count in the statistics, in the words of --pixels."""
    tissue: Tissue
    """The same as a mask; None: all."""
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
    def facts(self) -> dict[str, Any]:
        return {
            "kind": "enhanced picture",
            "source": self.source,
            "picture": self.name,
            "frame": self.frame,
            "method": self.job.method,
            "params": self.job.params,
            "pixels": self.job.pixels,
            "statistics": self.result.statistics,
            "omitted": self.result.omitted,
        }


def _pictures(
    series: Series, notices: list[str], indices: range | None = None
) -> Generator[ArrayImage, None, None]:
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


def _tissue(series: Series, flags: argparse.Namespace) -> Tissue:
    """Of each picture on its own, or where the statistics are those of all pictures, one mask for all."""
    if flags.pixels == "all":
        return lambda image: None
    if flags.statistics == "image":
        return lambda image: inside([image])
    size = series.read(0).shape[:2]
    spread = _pictures(series, [], series.spread(STEADY_FRAMES))
    try:
        steady = inside(image for image in spread if image.shape[:2] == size)
    except ImageError as error:
        raise UserError(f"{error}: {series.sources[0].parent}") from error
    return lambda image: steady if image.shape[:2] == size else inside([image])


def _pooled(series: Series, job: _Job, notices: list[str]) -> Statistics:
    assert job.params is not None
    # Both iterables of `measure_for` walk the same pictures in step: each is decoded once and let go.
    images, again = tee(_told("measure", series, ahead(_pictures(series, notices))))
    try:
        return measure_for(job.params, images, map(job.tissue, again))
    except ImageError as error:
        raise UserError(f"{error}: {series.sources[0].parent}") from error


def _enhanced(
    series: Series, images: Generator[ArrayImage, None, None], job: _Job
) -> Generator[_Picture, None, None]:
    origins, enhancer = series.origins(), LookEnhancer()
    try:
        for index, image in enumerate(images):
            try:
                mask = job.tissue(image) if job.statistics is None else None
                result = apply(job.method, job.params, image, mask, job.statistics, enhancer)
            except (ImageError, UserError) as error:
                raise UserError(f"{error}: {series.sources[index]}") from error
            frame = index if series.is_video else None
            yield _Picture(series.names[index], next(origins), frame, job, result)
    finally:
        images.close()


def _told(title: str, series: Series, items: Generator[T, None, None]) -> Generator[T, None, None]:
    """The items, with progress."""
    try:
        with progress(title, len(series)) as report:
            for index, item in enumerate(items):
                yield item
                report(index + 1, series.names[index])
    finally:
        items.close()


def _write(
    output: Path, series: Series, pictures: Iterator[_Picture], notices: list[str]
) -> list[dict[str, Any]]:
    """Write all pictures or none; what was used for each."""
    if output.suffix.lower() == VIDEO:
        return _write_video(output, series, pictures, notices)
    if is_image(output) and not output.is_dir():
        (picture,) = pictures
        write_image(output, picture.result.image, provenance(**picture.facts))
        return [{"output": output.name} | picture.facts]
    facts = []
    with filled(output) as staging:
        for picture in pictures:
            image = picture.result.image
            # PNG holds no floats.
            name = picture.name + (".tiff" if image.dtype.kind == "f" else ".png")
            write_image(staging / name, image, provenance(**picture.facts))
            facts.append({"output": name} | picture.facts)
    return facts


def _write_video(
    output: Path, series: Series, pictures: Iterator[_Picture], notices: list[str]
) -> list[dict[str, Any]]:
    """The video, and beside it its provenance, which this container does not carry."""
    facts = []

    def frames() -> Iterator[ArrayImage]:
        for picture in pictures:
            facts.append({"output": output.name} | picture.facts)
            yield picture.result.image

    like = series.sources[0] if series.is_video else None
    written = write_video(output, frames(), series.frames_per_second, like=like)
    notices.extend(written.notices)
    record = {"kind": "enhanced video", "frames_per_second": series.frames_per_second, "pictures": facts}
    write_sidecar(output, provenance(**record, encoding=written.encoding, notices=notices))
    return facts
