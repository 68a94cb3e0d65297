"""What a pane can show besides the frame and the current settings: computed off its thread, by value."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from app.enhancement.frame_enhancer import PictureMaker, PictureRequest, Pictures
from app.enhancement.methods import EnhancementSettings
from app.scenes.backgrounds import Background
from app.scenes.cpu_rendering import draw_on_cpu
from app.scenes.scene import Scene
from app.scenes.view_kinds import Scale
from app.scenes.view_request import ViewRequest
from enhance.baselines import BASELINES
from renderer.clip import ByteImage, Clip
from renderer.unobserved import GREY

KEPT_BYTES = 64 << 20
"""Of pictures that are kept, the last used ones, and of the models that they show."""
SCALES = (8, 16, 32, 64, 128, 255)
"""Grey levels that the top of the heat map can stand for."""
SHARE_WITHIN = 0.995
"""Of the pixels, whose difference the scale of the heat map holds."""


@dataclass(frozen=True)
class OtherRequest:
    """A picture of the same frame: by a setting, by a method without parameters, or by a model."""

    original: PictureRequest
    """The frame; its own params do not matter and are None."""
    by: EnhancementSettings | str | Scene
    background: Background = GREY
    """Of a reconstruction, where nothing was observed."""


@dataclass(frozen=True, eq=False)
class Other:
    """The picture with what it was made from."""

    request: OtherRequest
    image: ByteImage
    made: Pictures | None = None
    """Of a setting: with what it measured."""

    @property
    def arrays(self) -> list[NDArray[Any]]:
        """All that it keeps alive; windows of a long clip are read when they are needed."""
        by, model = self.request.by, list[NDArray[Any]]()
        if isinstance(by, Scene):
            arrays = by.model.arrays()
            model += (arrays if isinstance(arrays, dict) else by.model.raw.arrays()).values()
        return [self.image, *([self.made.original] if self.made else ()), *model]


class OtherMaker:
    """Answers OtherRequests; remembers the last pictures of a clip, so that going back and forth is free."""

    def __init__(self) -> None:
        self._pictures = PictureMaker()
        self._kept: OrderedDict[OtherRequest, Other] = OrderedDict()

    def make(self, request: OtherRequest) -> Iterator[Other]:
        """Raises ClipError or ImageError."""
        if any(kept.original.clip is not request.original.clip for kept in self._kept):
            self._kept.clear()
        if request not in self._kept:
            self._kept[request] = self._made(request)
        self._kept.move_to_end(request)
        while self._n_bytes() > KEPT_BYTES and len(self._kept) > 1:
            self._kept.popitem(last=False)
        yield self._kept[request]

    def _n_bytes(self) -> int:
        """Pictures share frames and models."""
        return sum({id(one): one.nbytes for kept in self._kept.values() for one in kept.arrays}.values())

    def _made(self, request: OtherRequest) -> Other:
        by, original = request.by, request.original
        if isinstance(by, Scene):
            return Other(request, _render(by, original.frame_index, request.background))
        if isinstance(by, str):
            return Other(request, BASELINES[by](original.clip.read_image(original.frame_index)))
        *_, made = self._pictures.make(replace(original, params=by))
        assert made.enhanced is not None
        return Other(request, made.enhanced, made)


def _render(scene: Scene, index: int, background: Background) -> ByteImage:
    """The model through the clip's own camera of that frame."""
    seen = ViewRequest.of_clip_frame(scene, index)
    return replace(seen, background=background).picture(draw_on_cpu).image


@dataclass(frozen=True, eq=False)
class DifferenceRequest:
    """Two pictures of one size; they are compared by identity, as they never change."""

    left: ByteImage
    right: ByteImage
    clip: Clip | None = None
    """Of which they are, where somebody waits for it."""

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, DifferenceRequest):
            return NotImplemented
        return other.left is self.left and other.right is self.right

    def __hash__(self) -> int:
        return hash((id(self.left), id(self.right)))


@dataclass(frozen=True, eq=False)
class Difference:
    """Where and by how much two pictures differ."""

    request: DifferenceRequest
    heat: ByteImage
    """(H, W, 3): black where they agree, through red to yellow."""
    top: int
    """Grey levels that the brightest colour stands for, and all above."""
    mean: float
    """Grey levels, of the largest channel."""


def heat_map(request: DifferenceRequest, top: int | None = None) -> Iterator[Difference]:
    """The largest difference of R, G and B at each pixel; the scale ends at `top` or holds nearly all."""
    apart = np.asarray(cv2.absdiff(request.left, request.right))
    red, green, blue = cv2.split(apart)
    largest = np.asarray(cv2.max(cv2.max(red, green), blue))
    below = np.cumsum(np.bincount(largest.ravel(), minlength=256)) / largest.size
    top = top or next(scale for scale in SCALES if below[scale] >= SHARE_WITHIN)
    levels = np.minimum(np.arange(256) * (255 / top), 255).astype(np.uint8)
    heat = np.asarray(heat_scale(top).table[levels[largest]], dtype=np.uint8)
    yield Difference(request, heat, top, float(largest.mean()))


def heat_scale(top: float) -> Scale:
    """The colours of the heat map, from no difference to the top."""
    return Scale(0.0, top, "grey levels", "inferno")
