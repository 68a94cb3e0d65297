"""Photo and enhanced photo of one frame, made off the window's thread from a request by value."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from time import perf_counter
from typing import Literal

import numpy as np

from enhance import EnhanceParams, Statistics, enhance, measure
from renderer.clip import ByteImage, Clip

Scope = Literal["image", "clip"]
POOLED_FRAMES = 16
"""Frames, evenly spread, whose statistics stand for the whole clip."""


@dataclass(frozen=True)
class PictureRequest:
    """Everything that the two pictures on screen depend on."""

    clip: Clip
    frame_index: int
    params: EnhanceParams | None
    """None: white light only."""
    scope: Scope = "image"
    """Statistics of this frame, or pooled over the clip so that playing does not flicker."""


@dataclass(frozen=True, eq=False)
class Pictures:
    """What is on screen; it keeps the request it was made from, and so knows when it is out of date."""

    request: PictureRequest
    photo: ByteImage
    enhanced: ByteImage | None = None
    """None while it is being made, or when it was not asked for."""
    statistics: Statistics | None = None
    milliseconds: float = 0.0
    """Of the enhancement alone."""


class PictureMaker:
    """Answers PictureRequests; remembers the newest clip's pooled statistics, which most requests share."""

    def __init__(self) -> None:
        self._pooled: tuple[Clip, EnhanceParams, Statistics] | None = None

    def make(self, request: PictureRequest) -> Iterator[Pictures]:
        """First the photo alone, then both. Raises ClipError or ImageError."""
        photo = request.clip.read_image(request.frame_index)
        yield Pictures(request, photo)
        if request.params is None:
            return
        statistics = self._of_clip(request.clip, request.params) if request.scope == "clip" else None
        start = perf_counter()
        result = enhance(photo, request.params, statistics=statistics)
        milliseconds = 1000 * (perf_counter() - start)
        enhanced = np.asarray(result.image, dtype=np.uint8)
        yield Pictures(request, photo, enhanced, result.statistics, milliseconds)

    def _of_clip(self, clip: Clip, params: EnhanceParams) -> Statistics:
        """What is measured depends on the windows alone; z and P are resolved again by `enhance`."""
        windows = EnhanceParams(radii=params.radii, eps=params.eps, subsample=params.subsample)
        if self._pooled is None or self._pooled[0] is not clip or self._pooled[1] != windows:
            count = min(len(clip), POOLED_FRAMES)
            frames = np.linspace(0, len(clip) - 1, count).round().astype(int)
            measured = measure((clip.read_image(int(index)) for index in frames), windows)
            self._pooled = (clip, windows, measured)
        return self._pooled[2]
