"""One frame, original and enhanced, computed off the window's thread from a request by value."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import tee
from time import perf_counter

import numpy as np

from app.enhancement.image_mask import NO_MASK, PictureMask
from app.enhancement.methods import EnhancementSettings, MethodEnhancer, load_kernels
from app.enhancement.settable import Pixels, Scope, drawn
from enhance import EnhanceParams, Statistics, measure
from enhance.result import Omission
from enhance.surround import inside
from renderer.clip import BoolImage, ByteImage, Clip

POOLED_FRAMES = 16
"""Frames, evenly spread, whose statistics stand for the whole clip."""
POOLS = 4
"""Sets of windows whose pooled statistics are remembered."""


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

    def with_params(self, params: EnhancementSettings) -> PictureRequest:
        """The same frame, enhanced by these."""
        return replace(self, params=params)


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
        self._shown: tuple[PictureRequest, ByteImage] | None = None
        self._pooled: dict[PictureRequest, Statistics] = {}

    def make(self, request: PictureRequest) -> Iterator[Pictures]:
        """First the frame alone, then both. Raises ClipError or ImageError."""
        original = self._show(request)
        yield Pictures(request, original)
        if request.params is None:
            return
        statistics = self._of_clip(request, request.params) if request.scope == "clip" else None
        self._load(request.params, original)
        start = perf_counter()
        result = self._enhancer.enhance(request.params, statistics=statistics)
        milliseconds = 1000 * (perf_counter() - start)
        enhanced = np.asarray(result.image, dtype=np.uint8)
        yield Pictures(request, original, enhanced, result.statistics, milliseconds, result.omitted)

    def _load(self, params: EnhancementSettings, original: ByteImage) -> None:
        """The kernels of a method, once: their way from disk is no time of a picture."""
        if type(params) not in self._loaded:
            self._loaded.add(type(params))
            load_kernels(params, original)
            # A search for garbage through all that numba keeps would stop the window for a tenth of a second.
            gc.freeze()

    def _show(self, request: PictureRequest) -> ByteImage:
        """The frame, read once for as long as only parameters move."""
        key = replace(request, params=None, scope="image")
        if self._shown is None or self._shown[0] != key:
            self._shown = None
            original, mask = _read(request, request.frame_index)
            self._enhancer.show(original, mask, drawn(request.pixels))
            self._shown = key, original
        return self._shown[1]

    def _of_clip(self, request: PictureRequest, params: EnhancementSettings) -> Statistics:
        """What is measured depends on the windows alone; z and P are resolved again by `enhance`."""
        paper = params if isinstance(params, EnhanceParams) else EnhanceParams()
        windows = EnhanceParams(radii=paper.radii, eps=paper.eps, subsample=paper.subsample)
        key = replace(request, frame_index=0, params=windows)
        if key not in self._pooled:
            while len(self._pooled) >= POOLS:
                self._pooled.pop(next(iter(self._pooled)))
            self._pooled[key] = _measured(key, windows)
        return self._pooled[key]


def _measured(request: PictureRequest, windows: EnhanceParams) -> Statistics:
    """Pooled over frames that are evenly spread over the clip."""
    first, last = request.span or (0, len(request.clip) - 1)
    indices = np.linspace(first, last, min(last + 1 - first, POOLED_FRAMES)).round().astype(int)
    # Both iterables of `measure` walk the same frames in step: each is decoded once and let go.
    frames, again = tee(_read(request, int(index)) for index in indices)
    images, masks = (image for image, _ in frames), (mask for _, mask in again)
    return measure(images, windows, masks, pixels=drawn(request.pixels))


def _read(request: PictureRequest, index: int) -> tuple[ByteImage, BoolImage | None]:
    """The frame and the pixels that count, None = all: so too where nothing but black would be left."""
    if request.pixels == "tissue":
        frame = request.clip.read_frame(index)
        image, mask = frame.image, frame.tissue_mask & inside([frame.image])
    elif request.mask == NO_MASK:
        return request.clip.read_image(index), None
    else:
        image = request.clip.read_image(index)
        mask = np.ones(image.shape[:2], dtype=bool)
    mask &= request.mask.kept(mask.shape)
    return image, mask if mask.any() else None
