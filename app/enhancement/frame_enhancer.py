"""One frame, original and enhanced, computed off the window's thread from a request by value."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from app.enhancement.clip_statistics import OfClip, StatisticsRequest, Tools, measured, read_frame, windows_of
from app.enhancement.image_mask import NO_MASK, PictureMask
from app.enhancement.methods import EnhancementSettings, MethodEnhancer, load_kernels
from app.enhancement.settable import Pixels, Scope, drawn
from enhance import Pool, Statistics
from enhance.result import Omission
from renderer.clip import BoolImage, ByteImage, Clip

POOLS = 4
"""Clips and sets of windows whose statistics are remembered."""


@dataclass(frozen=True)
class PictureRequest:
    """Everything that the two pictures on screen depend on."""

    clip: Clip
    frame_index: int
    params: EnhancementSettings | None
    """None: white light only."""
    scope: Scope = "image"
    """Statistics of this frame, or pooled over the clip so that playing does not flicker."""
    pixels: Pixels = "automatic"
    """What counts in the statistics."""
    mask: PictureMask = NO_MASK
    """What does not count either."""
    span: tuple[int, int] | None = None
    """First and last frame that are pooled; None: the whole clip."""
    of_clip: OfClip = None
    tools: Tools | None = None
    """Are no tissue, where tissue alone counts."""

    def statistics_request(self, params: EnhancementSettings) -> StatisticsRequest:
        """For the statistics of its clip."""
        windows = windows_of(params)
        return StatisticsRequest(
            self.clip, self.scope, windows, self.pixels, self.mask, self.span, self.tools
        )

    def with_params(self, params: EnhancementSettings) -> PictureRequest:
        """The same frame, enhanced by these; of the clip goes along what does not depend on what differs."""
        same = self.params is None or windows_of(self.params) == windows_of(params)
        return replace(self, params=params, of_clip=self.of_clip if same else None)


@dataclass(frozen=True, eq=False)
class Pictures:
    """What is on screen; it keeps the request it was made from, and so knows when it is out of date."""

    request: PictureRequest
    original: ByteImage
    enhanced: ByteImage | None = None
    """None while it is being made, or when it was not asked for."""
    statistics: Statistics | None = None
    milliseconds: float = 0.0
    """Of the enhancement alone."""
    omitted: tuple[Omission, ...] = ()
    """What this frame does without."""


class PictureMaker:
    """Answers PictureRequests; remembers what most of them share: the frame, of which a moved slider computes
    only what it changes, and the clip's pooled statistics."""

    def __init__(self) -> None:
        self._enhancer = MethodEnhancer()
        self._loaded: set[type[EnhancementSettings]] = set()
        self._shown: tuple[PictureRequest, ByteImage, BoolImage | None] | None = None
        self._pooled: dict[StatisticsRequest, Statistics | None] = {}
        self._first: tuple[StatisticsRequest, Statistics] | None = None

    def make(self, request: PictureRequest) -> Iterator[Pictures]:
        """First the frame alone, then both. Raises ClipError or ImageError."""
        given = self._show(request)
        original = _colors(given)
        yield Pictures(request, original)
        if request.params is None:
            return
        statistics = self._of_clip(request, request.params)
        self._load(request.params, given)
        start = perf_counter()
        result = self._enhancer.enhance(request.params, statistics=statistics)
        milliseconds = 1000 * (perf_counter() - start)
        enhanced = _colors(np.asarray(result.image, dtype=np.uint8))
        yield Pictures(request, original, enhanced, result.statistics, milliseconds, result.omitted)

    def _load(self, params: EnhancementSettings, given: ByteImage) -> None:
        """The kernels of a method, once: their way from disk is no time of a picture."""
        if type(params) not in self._loaded:
            self._loaded.add(type(params))
            load_kernels(params, given)
            # A search for garbage through all that numba keeps would stop the window for a tenth of a second.
            gc.freeze()

    def _show(self, request: PictureRequest) -> ByteImage:
        """The frame, see `read_frame`, read once for as long as only parameters move."""
        key = replace(request, params=None, scope="image", of_clip=None)
        if self._shown is None or self._shown[0] != key:
            self._shown = None
            given, mask = read_frame(
                request.clip, request.frame_index, request.pixels, request.mask, request.tools
            )
            self._enhancer.show(given, mask, drawn(request.pixels))
            self._shown = key, given, mask
        return self._shown[1]

    def _of_clip(self, request: PictureRequest, params: EnhancementSettings) -> Statistics | None:
        """What all frames of the clip are enhanced with; None: each with its own."""
        if request.scope == "image" or request.of_clip == "own":
            return None
        if isinstance(request.of_clip, Statistics):
            return request.of_clip
        key = request.statistics_request(params)
        if request.of_clip == "later":
            return self._of_first(key)
        if key not in self._pooled:
            while len(self._pooled) >= POOLS:
                self._pooled.pop(next(iter(self._pooled)))
            self._pooled[key] = measured(key)
        return self._pooled[key]

    def _of_first(self, key: StatisticsRequest) -> Statistics:
        """Of the frame that was shown first since these have been asked for."""
        if self._first is None or self._first[0] != key:
            assert self._shown is not None
            pool = Pool(key.windows, drawn(key.pixels))
            pool.add(*self._shown[1:])
            self._first = key, pool.statistics()
        return self._first[1]


def _colors(image: ByteImage) -> ByteImage:
    """(H, W, 3), without alpha."""
    return image if image.shape[2] == 3 else np.ascontiguousarray(image[..., :3])
