"""The black surround of a round endoscope picture, which says nothing about tissue."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.brightness import BLACK, value
from enhance.image import AnyImage, BoolImage, ImageError, read_picture

LEAST_SHARE: Final = 0.01
"""Of the picture: smaller dark corners are shadow."""
RIM: Final = 2
"""Pixels next to the surround that are half dark."""


def inside(images: Iterable[AnyImage]) -> BoolImage:
    """(H, W) True = picture, False = the black surround and its half-dark rim: what is dark and connected to
    the border of the picture.

    Dark is V below 24 of 255 after a 5x5 median: camera noise and compression included. Dark tissue that
    touches the border is taken for it, too; dark corners of less than a hundredth of the picture are shadow,
    and what is black from edge to edge has no surround. Of several images of one size, one mask for all: of
    what is dark in more than half of them, so that neither a flash nor a dark moment moves it.

    Raises:
        ImageError: an image that cannot be used, images of two sizes, or none.
    """
    dark = DarkVotes()
    for image in images:
        dark.add(image)
    return dark.inside()


class DarkVotes:
    """In how many images of one size each pixel is dark, one image after another."""

    def __init__(self) -> None:
        self._votes, self._count = np.zeros((0, 0), np.int32), 0

    def add(self, image: AnyImage) -> None:
        """Raises ImageError: it cannot be used, or is of another size."""
        dark = cv2.medianBlur(_levels(image), 5) < 255 * BLACK
        if self._count and self._votes.shape != dark.shape:
            raise ImageError(f"expected images of one size, got {self._votes.shape} and {dark.shape}")
        self._votes = self._votes + dark if self._count else dark.astype(np.int32)
        self._count += 1

    def inside(self) -> BoolImage:
        """As the function of that name. Raises ImageError: no image was added."""
        if self._count == 0:
            raise ImageError("expected at least one image, got none")
        dark = (2 * self._votes > self._count).astype(np.uint8)
        kept = np.asarray(cv2.dilate(_surround(dark), np.ones((2 * RIM + 1, 2 * RIM + 1), np.uint8)) == 0)
        return kept if kept.any() else np.ones_like(kept)


def _surround(dark: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """(H, W) 1 in the large dark parts that touch the border."""
    _, labels, facts, _ = cv2.connectedComponentsWithStats(dark, connectivity=4)
    outer = np.zeros(len(facts), dtype=bool)
    for side in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
        outer[side] = True
    outer &= facts[:, cv2.CC_STAT_AREA] >= LEAST_SHARE * dark.size
    outer[0] = False
    return np.asarray(outer[labels], np.uint8)


def _levels(image: AnyImage) -> AnyImage:
    """(H, W) V in grey levels, uint8."""
    picture = read_picture(image)
    if picture.dtype != np.uint8:
        return np.rint(255 * value(picture.colors)).astype(np.uint8)
    first, *others = cv2.split(picture.pixels)
    for plane in others:
        first = cv2.max(first, plane)
    return np.asarray(first)
