"""Panels burned into the image, and tools at rest: what stands still and is found in most frames of a clip is
masked in all of those where it looks the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Final, Self

import cv2
import numpy as np
from annotated_types import Interval, Len
from numpy.typing import NDArray
from pydantic import StringConstraints

from renderer.clip import ByteImage
from renderer.tools.shrinking import SIDE, SMALLEST, disc

NOISE: Final = 12
"""Grey levels by which what looks the same may differ, in each of R, G and B."""
ALIKE: Final = 0.9
"""Share: of the frames, in which a pixel that stands still looks the same; of an area's pixels in a frame."""
CELL: Final = 8
"""px of the small image: the look of an area is kept as the mean colours of squares of that side."""
_FEWEST = 3  # Images; of fewer nobody knows what stands still.
_OPENING = 5  # px of the small image: thinner than that are edges of what moves.

Indices = NDArray[np.intp]
Place = Annotated[int, Interval(ge=0, lt=SIDE)]


@dataclass(frozen=True)
class StillArea:
    """Of a small image, (h, w, 3) RGB, as `shrunk` makes it of a frame."""

    outline: Annotated[tuple[tuple[Place, Place], ...], Len(1)]
    """x and y of its corners, px that belong to it."""
    look: Annotated[str, StringConstraints(pattern="^([0-9a-f]{6})+$")]
    """Mean colours of its cells, row by row, hexadecimal; cells that hold nothing of it are left out."""

    @classmethod
    def of(cls, outline: NDArray[np.int32], images: Sequence[ByteImage]) -> Self:
        """(N, 2) corners; it looks as the median of the images, (h, w, 3) each."""
        corners = tuple((int(x), int(y)) for x, y in outline)
        y, x, cells = cls(corners, "")._pixels
        look, _ = _means(_median([image[y, x] for image in images]), cells)
        return cls(corners, np.rint(look).astype(np.uint8).tobytes().hex())

    def added(self, tools: ByteImage, small: ByteImage) -> ByteImage:
        """`tools` (h, w), 1 here, too; as it is where the image (h, w, 3) looks otherwise here."""
        y, x, cells = self._pixels
        known = np.frombuffer(bytes.fromhex(self.look), np.uint8).reshape(-1, 3)
        is_of_this_size = y.max() < small.shape[0] and x.max() < small.shape[1] and cells.max() < len(known)
        if not is_of_this_size or tools[y, x].all():
            return tools
        look, sizes = _means(small[y, x], cells)
        same = (np.abs(look - known) <= NOISE).all(axis=1)
        if sizes[same].sum() < ALIKE * len(y):
            return tools
        wider = tools.copy()
        wider[y, x] = 1
        return wider

    @cached_property
    def _pixels(self) -> tuple[Indices, Indices, Indices]:
        """y, x and cell of each: cells are numbered row by row."""
        outline = np.array(self.outline, np.int32)
        left, top, width, height = cv2.boundingRect(outline)
        inside = np.zeros((height, width), np.uint8)
        cv2.fillPoly(inside, [outline - np.array((left, top), np.int32)], 1)
        y, x = np.nonzero(inside)
        _, cells = np.unique(y // CELL * (width // CELL + 1) + x // CELL, return_inverse=True)
        return y + top, x + left, cells


def still_areas(images: Sequence[ByteImage], found: Sequence[ByteImage]) -> tuple[StillArea, ...]:
    """What stands still in these small images of a clip, (h, w, 3), and is found in most of them.

    `found` (h, w) is not 0 where a tool is found in an image, without its margin. It takes both: tissue
    stands still, too, where the camera does. The constants were chosen on training frames of the mesentery
    clip, whose camera is at rest.
    """
    if len(images) < _FEWEST:
        return ()
    counts = np.sum(np.array(found) > 0, axis=0, dtype=np.int32)
    most = np.flatnonzero(counts > len(found) / 2)
    pixels = np.array([image.reshape(-1, 3).take(most, axis=0) for image in images])
    typical = _median(pixels).astype(np.int16)
    low, high = ((typical + by).clip(0, 255).astype(np.uint8) for by in (-NOISE, NOISE))
    same = (low <= pixels) & (pixels <= high)
    still = np.zeros(counts.shape, np.uint8)
    still.flat[most] = np.mean(same[:, :, 0] & same[:, :, 1] & same[:, :, 2], axis=0) >= ALIKE
    opened = cv2.morphologyEx(still, cv2.MORPH_OPEN, disc(_OPENING))
    outlines, _ = cv2.findContours(opened, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    large = (one for one in outlines if cv2.contourArea(one) > SMALLEST * still.size)
    corners = (cv2.approxPolyDP(one, 1, closed=True)[:, 0].astype(np.int32) for one in large)
    return tuple(StillArea.of(each, images) for each in corners)


def _median(values: Sequence[ByteImage] | ByteImage) -> ByteImage:
    """Along the first axis; the upper one of an even number."""
    middle = len(values) // 2
    return np.asarray(np.partition(np.asarray(values), middle, axis=0)[middle])


def _means(pixels: ByteImage, cells: Indices) -> tuple[NDArray[np.float64], Indices]:
    """(C, 3) mean colours of the cells that pixels (P, 3) are in, and how many are."""
    sizes = np.bincount(cells)
    sums = [np.bincount(cells, weights=values) for values in pixels.T]
    return np.stack(sums, axis=1) / sizes[:, None], sizes
