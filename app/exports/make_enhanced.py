"""Enhanced pictures, videos of them and tuning sheets, of their records."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from app.enhancement.contact_sheet import tile, write_tuning_sheet
from app.enhancement.enhance_files import Made, enhanced, write_enhanced_video
from app.enhancement.methods import METHODS, MethodEnhancer
from app.enhancement.parameter_grid import Setting, tried
from app.enhancement.records import EnhancedPicture, EnhancedVideo, TuningSheet
from app.errors import UserError
from app.exports.sources import Sources
from app.files.image_files import write_image
from app.files.image_series import Series
from app.files.records import Source
from app.files.stepping import map_steps
from enhance.surround import inside
from renderer.readers.clip_options import DEFAULTS, ClipOptions


def make_picture(record: EnhancedPicture, sources: Sources, target: Path) -> None:
    """Raises UserError, ClipError or ImageError."""
    image, made = _made(record, _series(record, sources), MethodEnhancer())
    write_image(target, image, made.signed)


def make_video(record: EnhancedVideo, sources: Sources, target: Path) -> Generator[int, None, None]:
    """Raises UserError, ClipError or ImageError."""
    if not record.pictures:
        raise UserError("expected at least one frame, got none")
    enhancer = MethodEnhancer()

    @lru_cache(maxsize=1)
    def opened(source: Source) -> Series:
        return _series(next(one for one in record.pictures if one.source == source), sources)

    def pictures() -> Iterator[Made]:
        for picture in record.pictures:
            yield _made(picture, opened(picture.source), enhancer)

    timing = replace(opened(record.pictures[0].source).timing, frames_per_second=record.frames_per_second)
    yield from map_steps(write_enhanced_video(target, pictures(), timing, []), lambda done: done)


def make_sheet(record: TuningSheet, sources: Sources, target: Path) -> None:
    """Raises UserError, ClipError or ImageError."""
    series, frame = sources.series(record.source, DEFAULTS), record.frame or 0
    if not 0 <= frame < len(series) or not record.settings or record.columns < 1:
        raise UserError(f"expected settings, columns and one of {len(series)} frames")
    image = series.read(frame)
    mask = inside([image]) if record.pixels == "tissue" else None
    wanted = [Setting((place,), one.label, one.params) for place, one in enumerate(record.settings)]
    tiles = {cell.setting: tile(cell) for cell in tried(image, wanted, mask)}
    write_tuning_sheet(target, record, [tiles[setting] for setting in wanted])


def _series(record: EnhancedPicture, sources: Sources) -> Series:
    return sources.series(record.source, ClipOptions(deinterlacing=record.deinterlacing))


def _made(record: EnhancedPicture, series: Series, enhancer: MethodEnhancer) -> Made:
    frame = record.frame or 0
    if record.method not in METHODS or not 0 <= frame < len(series):
        raise UserError(
            f"expected one of {len(series)} frames and a known method, got {record.method} of {frame}"
        )
    return enhanced(record, series.read(frame), enhancer)
