"""Enhanced images and videos, reproduced."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Literal

from pydantic import ConfigDict, TypeAdapter
from pydantic.dataclasses import dataclass

from app.enhancement.methods import METHODS, MethodEnhancer, apply
from app.errors import UserError
from app.exports.replay.recorded import Facts, again
from app.exports.replay.sources import Named, Sources
from app.files.image_files import ArrayImage, write_image
from app.files.image_series import Series, open_series
from app.files.provenance import write_sidecar
from app.files.video import write_video
from app.runs.run_folder import RecordedSettings
from enhance import Statistics
from enhance.surround import inside
from renderer.readers.clip_options import ClipOptions, Deinterlacing


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class EnhancedFacts:
    """What an enhanced picture says of itself, as far as its pixels depend on it."""

    source: Named
    frame: int | None
    """Of a video."""
    method: str
    params: RecordedSettings | None
    pixels: Literal["all", "tissue"]
    statistics: Statistics | None
    deinterlacing: Deinterlacing = "frame"

    def opened(self, sources: Sources) -> Series:
        """Raises UserError or ClipError: the source is not to be found, or cannot be read."""
        return open_series(sources.find(self.source), ClipOptions(deinterlacing=self.deinterlacing))


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class VideoFacts:
    """What an enhanced video says of itself."""

    frames_per_second: float
    pictures: tuple[EnhancedFacts, ...]


PICTURE = TypeAdapter(EnhancedFacts)
VIDEO = TypeAdapter(VideoFacts)


def remake_enhanced(facts: Facts, sources: Sources, target: Path) -> None:
    """Raises UserError, ClipError, ImageError or pydantic.ValidationError."""
    picture = PICTURE.validate_python(facts)
    series = picture.opened(sources)
    write_image(target, _enhanced(picture, series, MethodEnhancer()), again(facts))


def remake_enhanced_video(facts: Facts, sources: Sources, target: Path) -> None:
    """Raises UserError, ClipError, ImageError or pydantic.ValidationError."""
    video = VIDEO.validate_python(facts)
    if not video.pictures:
        raise UserError(f"expected at least one frame, got none: {sources.file}")
    enhancer = MethodEnhancer()

    @lru_cache(maxsize=1)
    def opened(source: Named) -> Series:
        return next(one for one in video.pictures if one.source == source).opened(sources)

    def frames() -> Iterator[ArrayImage]:
        for picture in video.pictures:
            yield _enhanced(picture, opened(picture.source), enhancer)

    timing = opened(video.pictures[0].source).timing
    write_video(target, frames(), replace(timing, frames_per_second=video.frames_per_second))
    write_sidecar(target, again(facts))


def _enhanced(picture: EnhancedFacts, series: Series, enhancer: MethodEnhancer) -> ArrayImage:
    """Statistics of the picture alone are measured again; those of all pictures together are taken over."""
    frame = picture.frame or 0
    if picture.method not in METHODS or not 0 <= frame < len(series):
        raise UserError(
            f"expected one of {len(series)} frames and a known method, got {picture.method} of {frame}"
        )
    image = series.read(frame)
    pooled = picture.statistics if picture.statistics and picture.statistics.scope != "image" else None
    mask = inside([image]) if pooled is None and picture.pixels == "tissue" else None
    return apply(picture.method, picture.params, image, mask, pooled, enhancer).image
