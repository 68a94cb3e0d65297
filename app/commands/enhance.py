"""`vesselsplat enhance INPUT OUTPUT`: pictures in, enhanced pictures out."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from app.arguments import add_fields, parameters
from app.atomic import filled, write_bytes
from app.errors import UserError
from app.pictures import ArrayImage, is_image, write_image
from app.progress import progress
from app.provenance import provenance, source, strict_json
from app.series import Series, open_series
from app.video import write_video
from enhance import EnhanceParams, EnhanceResult, ImageError, Statistics, enhance, measure

FIELDS = ("z", "p", "radii", "eps", "subsample", "d_factor", "keep_black")
VIDEO = ".mp4"


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("input", metavar="INPUT", type=Path, help="picture, folder of pictures or video")
    parser.add_argument("output", metavar="OUTPUT", type=Path, help="picture, folder or .mp4 video to write")
    add_fields(parser, EnhanceParams, FIELDS)
    parser.add_argument(
        "--statistics",
        choices=("image", "clip"),
        default="image",
        help="measure each picture on its own, or all together so that colours agree (default image)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def run(flags: argparse.Namespace) -> None:
    params = parameters(EnhanceParams, flags)
    series = open_series(flags.input)
    _check_output(flags.input, flags.output, series)
    started = time.perf_counter()
    statistics = _pooled(series, params) if flags.statistics == "clip" else None
    pictures = _write(flags.output, series, _enhanced(series, params, statistics))
    seconds = time.perf_counter() - started
    for notice in series.notices:
        sys.stderr.write(f"{notice}\n")
    if flags.json:
        summary = provenance(params=params, pictures=pictures, seconds=seconds)
        sys.stdout.write(strict_json(summary) + "\n")
    else:
        sys.stdout.write(f"{flags.output}: {len(series)} enhanced in {seconds:.1f} s\n")


def _check_output(given: Path, output: Path, series: Series) -> None:
    """Refuse what would overwrite the input, or has no place for what comes."""
    files = {path.resolve() for path in series.sources}
    taken = {given.resolve(), *files, *((path.parent for path in files) if given.is_dir() else ())}
    if output.resolve() in taken or (output.is_dir() and output.resolve() in {path.parent for path in files}):
        raise UserError(f"expected another OUTPUT than INPUT, which is never overwritten: {output}")
    if is_image(output) and len(series) > 1:
        raise UserError(f"expected a folder or {VIDEO} for {len(series)} pictures, got {output}")
    if output.suffix and not (is_image(output) or output.suffix.lower() == VIDEO or output.is_dir()):
        raise UserError(f"expected a picture, a folder or {VIDEO} to write, got {output}")


@dataclass(frozen=True, eq=False)
class _Enhanced:
    name: str
    source: dict[str, str]
    params: EnhanceParams
    result: EnhanceResult

    @property
    def image(self) -> ArrayImage:
        return self.result.image

    @property
    def facts(self) -> dict[str, Any]:
        return {
            "source": self.source,
            "picture": self.name,
            "params": self.params,
            "statistics": self.result.statistics,
            "omitted": self.result.omitted,
        }


def _pooled(series: Series, params: EnhanceParams) -> Statistics:
    try:
        return measure(_told("measure", series), params)
    except ImageError as error:
        raise UserError(f"{error}: {series.sources[0].parent}") from error


def _enhanced(series: Series, params: EnhanceParams, statistics: Statistics | None) -> Iterator[_Enhanced]:
    origins = _origins(series)
    for index, image in enumerate(_told("enhance", series)):
        try:
            result = enhance(image, params, statistics=statistics)
        except ImageError as error:
            raise UserError(f"{error}: {series.sources[index]}") from error
        yield _Enhanced(series.names[index], next(origins), params, result)


def _origins(series: Series) -> Iterator[dict[str, str]]:
    """Name and digest of each picture's file; that of a video is taken once."""
    for path, pictures in groupby(series.sources):
        origin = source(path)
        yield from (origin for _ in pictures)


def _told(title: str, series: Series) -> Iterator[ArrayImage]:
    """The pictures, with progress."""
    with progress(title, len(series)) as report:
        for index, image in enumerate(series):
            yield image
            report(index + 1, series.names[index])


def _write(output: Path, series: Series, pictures: Iterator[_Enhanced]) -> list[dict[str, Any]]:
    """Write all pictures or none; what was used for each."""
    if output.suffix.lower() == VIDEO:
        return _write_video(output, series, pictures)
    if is_image(output) and not output.is_dir():
        (picture,) = pictures
        write_image(output, picture.image, provenance(**picture.facts))
        return [{"output": output.name} | picture.facts]
    facts = []
    with filled(output) as staging:
        for picture in pictures:
            # PNG holds no floats.
            name = picture.name + (".tiff" if picture.image.dtype.kind == "f" else ".png")
            write_image(staging / name, picture.image, provenance(**picture.facts))
            facts.append({"output": name} | picture.facts)
    return facts


def _write_video(output: Path, series: Series, pictures: Iterator[_Enhanced]) -> list[dict[str, Any]]:
    """The video, and beside it its provenance, which this container does not carry."""
    facts = []

    def frames() -> Iterator[ArrayImage]:
        for picture in pictures:
            facts.append({"output": output.name} | picture.facts)
            yield picture.image

    write_video(output, frames(), series.frames_per_second)
    sidecar = output.with_name(f"{output.name}.json")
    write_bytes(sidecar, strict_json(provenance(pictures=facts), indent=2).encode())
    return facts
