"""Small images: of what each preset makes of the frame on screen, so that choosing one is looking."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np

from app.enhancement.frame_enhancer import Pictures
from app.enhancement.methods import EnhancementSettings, MethodEnhancer
from app.enhancement.settable import drawn
from enhance import EnhanceParams
from renderer.clip import ByteImage

SIDE: Final = 160
"""Pixels of the longer side."""


@dataclass(frozen=True)
class ThumbnailsRequest:
    """A frame, and settings by name."""

    pictures: Pictures
    looks: tuple[tuple[str, EnhancementSettings], ...]


@dataclass(frozen=True, eq=False)
class Thumbnails:
    """(h, w, 3) of each setting."""

    request: ThumbnailsRequest
    images: Mapping[str, ByteImage]


def make_thumbnails(request: ThumbnailsRequest) -> Iterator[Thumbnails]:
    """Raises ImageError."""
    original = request.pictures.original
    factor, enhancer = min(1.0, SIDE / max(original.shape[:2])), MethodEnhancer()
    enhancer.show(shrunk(original, SIDE, SIDE), None, drawn(request.pictures.request.pixels))
    images = {
        name: np.asarray(enhancer.enhance(smaller(look, factor)).image, np.uint8)
        for name, look in request.looks
    }
    yield Thumbnails(request, images)


def shrunk(image: ByteImage, width: int, height: int, pixel_aspect: float = 1.0) -> ByteImage:
    """(h, w, 3): as large as it fits into so many pixels, and no larger than it is; its pixels, which are
    `pixel_aspect` times as wide as high, become square."""
    high, wide = image.shape[0], pixel_aspect * image.shape[1]
    scale = min(width / wide, height / high, 1.0)
    size = max(1, round(scale * wide)), max(1, round(scale * high))
    if size == (image.shape[1], high):
        return image
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)


def smaller(look: EnhancementSettings, factor: float) -> EnhancementSettings:
    """With windows that cover as much of a picture that is `factor` times as large."""
    if isinstance(look, EnhanceParams):
        return replace(look, radii=tuple(max(1, round(factor * r)) for r in look.radii), subsample=1)
    return replace(look, radius=max(2, round(factor * look.radius)))
