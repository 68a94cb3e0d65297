"""The statistics of a clip, measured frame by frame, so that all its frames are enhanced alike."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass
from typing import Final, Literal, Protocol

import numpy as np

from app.enhancement.image_mask import NO_MASK, PictureMask
from app.enhancement.methods import EnhancementSettings
from app.enhancement.recording import are_alike, likenesses
from app.enhancement.settable import POOLED_FRAMES, Pixels, Scope, drawn
from enhance import EnhanceParams, Pool, Statistics
from enhance.surround import inside
from renderer.clip import BoolImage, ByteImage, Clip
from renderer.evenly import evenly

IMAGES: Final = "images"
"""Format of a clip that is a folder of images, of one recording or not."""
OfClip = Statistics | Literal["own", "later"] | None
"""Statistics of a clip where they are known, "own" where each frame has its own; "later": until they are
known, those of the first frame that is shown stand for them; None: measured when they are needed."""


class Tools(Protocol):
    """Tools that a person has masked, by value: they are no tissue."""

    def of(self, clip: Clip) -> Clip:
        """The clip without them."""


@dataclass(frozen=True)
class StatisticsRequest:
    """All that the statistics of a clip depend on."""

    clip: Clip
    scope: Scope
    windows: EnhanceParams
    """Radii, eps and subsample count; z and P are resolved again for each frame."""
    pixels: Pixels
    mask: PictureMask = NO_MASK
    span: tuple[int, int] | None = None
    """First and last frame; None: the whole clip."""
    tools: Tools | None = None


@dataclass(frozen=True, eq=False)
class ClipStatistics:
    """With the request that they answer."""

    request: StatisticsRequest
    statistics: Statistics | None
    """None: each frame has its own."""

    def told(self, request: StatisticsRequest) -> OfClip:
        """To those who ask for them; None: of another clip, or measured otherwise."""
        return (self.statistics or "own") if request == self.request else None


def windows_of(params: EnhancementSettings) -> EnhanceParams:
    """What of the parameters the statistics of a clip depend on."""
    paper = params if isinstance(params, EnhanceParams) else EnhanceParams()
    return EnhanceParams(radii=paper.radii, eps=paper.eps, subsample=paper.subsample)


class ClipMeasurer:
    """Measures clips. Asked again for the one that it was given up with, it goes on where it was."""

    def __init__(self) -> None:
        self._under_way: tuple[StatisticsRequest, Pool, list[int]] | None = None

    def measure(self, request: StatisticsRequest) -> Iterator[ClipStatistics | None]:
        """None after each step, at last the statistics. Raises ClipError or ImageError."""
        if not (yield from _pools(request)):
            yield ClipStatistics(request, None)
            return
        if self._under_way is None or self._under_way[0] != request:
            self._under_way = request, Pool(request.windows, drawn(request.pixels)), _indices(request)
        _, pool, indices = self._under_way
        while indices:
            pool.add(*read_frame(request.clip, indices[0], request.pixels, request.mask, request.tools))
            del indices[0]
            yield None
        self._under_way = None
        yield ClipStatistics(request, pool.statistics())


def measured(request: StatisticsRequest) -> Statistics | None:
    """At once. Raises ClipError or ImageError."""
    *_, last = ClipMeasurer().measure(request)
    assert last is not None
    return last.statistics


def _pools(request: StatisticsRequest) -> Generator[None, None, bool]:
    """Whether the frames share their statistics; of a folder of images that takes a look at some."""
    clip, found = request.clip, list[float]()
    if request.scope != "automatic":
        return request.scope == "clip"
    if clip.format != IMAGES:
        return len(clip) > 1
    for likeness in likenesses(len(clip), clip.read_image):
        found.append(likeness)
        yield
    return are_alike(found)


def _indices(request: StatisticsRequest) -> list[int]:
    first, last = request.span or (0, len(request.clip) - 1)
    return evenly(range(first, last + 1), POOLED_FRAMES)


def read_frame(
    clip: Clip, index: int, pixels: Pixels, mask: PictureMask, tools: Tools | None = None
) -> tuple[ByteImage, BoolImage | None]:
    """The frame, (H, W, 3), or (H, W, 4) with what is seen of it as alpha, and the pixels that count, None =
    all: so too where nothing but black would be left."""
    image, kept = _read(clip, index, pixels, mask, tools)
    visible = clip.read_visible(index) if clip.read_visible else None
    if visible is not None and visible.any():
        image = np.dstack((image, np.where(visible, 255, 0).astype(np.uint8)))
    return image, kept


def _read(
    clip: Clip, index: int, pixels: Pixels, mask: PictureMask, tools: Tools | None
) -> tuple[ByteImage, BoolImage | None]:
    if pixels == "tissue":
        frame = (clip if tools is None else tools.of(clip)).read_frame(index)
        image, kept = frame.image, frame.tissue_mask & inside([frame.image])
    elif mask == NO_MASK:
        return clip.read_image(index), None
    else:
        image = clip.read_image(index)
        kept = np.ones(image.shape[:2], dtype=bool)
    kept &= mask.kept(kept.shape)
    return image, kept if kept.any() else None
