"""Small images of a clip for its frame strip, and what of a frame is left out: off the window's thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from app.enhancement.image_mask import PictureMask
from app.runs.left_out import found_around
from app.runs.tool_masks import ToolMasks
from renderer.clip import BoolImage, ByteImage, Clip, ClipError

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


@dataclass(frozen=True)
class LeftOutRequest:
    """Of one frame."""

    clip: Clip
    frame_index: int
    mask: PictureMask
    tool_masks: ToolMasks | None = None
    changes: int = 0
    """Of these masks on disk: others are another request."""


@dataclass(frozen=True, eq=False)
class LeftOut:
    """(H, W), True = tool, burned-in text, dark surround, or masked by hand; tools and surround as a
    reconstruction finds them where the clip has no masks."""

    request: LeftOutRequest
    pixels: BoolImage


def left_out(request: LeftOutRequest) -> Iterator[LeftOut]:
    """Raises ClipError."""
    clip = request.clip if request.tool_masks is None else request.tool_masks.of(request.clip)
    found, frame = found_around(clip, request.frame_index)
    tissue = found.cleared(frame).tissue_mask
    yield LeftOut(request, ~(tissue & request.mask.kept(tissue.shape)))
