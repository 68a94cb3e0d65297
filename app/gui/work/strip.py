"""Small images of a clip for its frame strip: off the window's thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from renderer.clip import ByteImage, Clip, ClipError

HEIGHT = 72
"""Rows of the strip's picture, which the window scales."""
MOST = 40
"""Small pictures in it, whatever the clip's length."""
GROUND = 28
DAMAGED, CROSS = 92, 200
"""Grey levels of what stands for a frame that cannot be read, and of the cross through it."""


@dataclass(frozen=True)
class StripRequest:
    """So many small pictures, evenly spread over the clip, side by side."""

    clip: Clip
    count: int


@dataclass(frozen=True, eq=False)
class Strip:
    request: StripRequest
    image: ByteImage
    """(HEIGHT, W, 3)."""

    def edges(self, width: float, height: float) -> list[tuple[float, float]]:
        """Left and right of each small picture in a strip of that size on the screen: in its share of it, in
        the frames' own shape."""
        rows, columns = self.image.shape[:2]
        share = width / self.request.count
        shown = min(share, height * columns / self.request.count / rows)
        lefts = [place * share + (share - shown) / 2 for place in range(self.request.count)]
        return [(left, left + shown) for left in lefts]


def count_for(clip: Clip, width: float, height: float) -> int:
    """How many small pictures fill a strip of that size on the screen."""
    return int(min(max(width / max(height * _shape(clip), 1), 1), len(clip), MOST))


def _shape(clip: Clip) -> float:
    """Width by height on the screen."""
    return clip.pixel_aspect * clip.size[0] / clip.size[1]


def make_strip(request: StripRequest) -> Iterator[Strip]:
    """Better with every frame that is read; one that cannot be read is grey, with a cross."""
    clip, count = request.clip, request.count
    width = max(1, round(HEIGHT * _shape(clip)))
    image = np.full((HEIGHT, width * count, 3), GROUND, np.uint8)
    for place in range(count):
        frame = int((place + 0.5) * len(clip) / count)
        tile = image[:, place * width : (place + 1) * width]
        try:
            _put(clip.read_image(frame), clip.pixel_aspect, tile)
        except ClipError:
            _cross_out(tile)
        yield Strip(request, image.copy())


def _cross_out(place: ByteImage) -> None:
    tile = np.full(place.shape, DAMAGED, np.uint8)
    (y, x), reach = (side // 2 for side in place.shape[:2]), min(place.shape[:2]) // 4
    for way in (reach, -reach):
        cv2.line(tile, (x - reach, y - way), (x + reach, y + way), (CROSS,) * 3, 3, cv2.LINE_AA)
    place[:] = tile


def _put(frame: ByteImage, pixel_aspect: float, place: ByteImage) -> None:
    """In its own shape, in the middle."""
    (height, width), rows, columns = place.shape[:2], frame.shape[0], pixel_aspect * frame.shape[1]
    scale = min(height / rows, width / columns)
    size = max(1, min(width, round(columns * scale))), max(1, min(height, round(rows * scale)))
    left, top = (width - size[0]) // 2, (height - size[1]) // 2
    small = cv2.resize(frame, size, interpolation=cv2.INTER_AREA)
    place[top : top + size[1], left : left + size[0]] = small
