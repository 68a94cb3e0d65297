"""The visible part of an image, one array pixel for each pixel of the screen.

The window system's own sampling knows no averaging, so that thin vessels of an image shown smaller would
flicker; here both panes are sampled alike, by a filter that follows from the zoom.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from app.gui.views.picture_view import Placement
from renderer.clip import BoolImage, ByteImage

SHARP_ZOOM = 3.0
"""From here on pixels are shown as squares."""
NEARLY_WHOLE = 0.95
"""From here to 1, interpolation weighs all pixels alike to 5 %, in a sixth of the time of averages."""
STRIPE = 8
"""Screen pixels from one stripe of the zebra to the next."""
OVER, UNDER = (255, 0, 255), (255, 220, 0)
"""Stripes on clipped highlights and shadows: colours that tissue does not have."""
TINT, TINT_SHARE = (40, 200, 170), 0.45
"""Over tools and what is masked."""


@dataclass(frozen=True, eq=False)
class Patch:
    """Screen pixels (H, W, 3) to be drawn with their upper left corner at (x, y) in the pane."""

    pixels: ByteImage
    x: int
    y: int


def visible(image: ByteImage, place: Placement, pane: tuple[float, float]) -> Patch | None:
    """The part of an (H, W, 3) or (H, W) image that a pane of (width, height) pixels shows; None: nothing."""
    columns = _span(place.offset_x, place.zoom_x, image.shape[1], pane[0])
    rows = _span(place.offset_y, place.zoom, image.shape[0], pane[1])
    if columns is None or rows is None:
        return None
    part = image[rows[0] : rows[1], columns[0] : columns[1]]
    x, width = _target(columns, place.offset_x, place.zoom_x)
    y, height = _target(rows, place.offset_y, place.zoom)
    if (width, height) == (part.shape[1], part.shape[0]):
        return Patch(np.ascontiguousarray(part), x, y)
    part = _halved(part, max(place.zoom, place.zoom_x))
    sampled = cv2.resize(part, (width, height), interpolation=_filter(min(place.zoom, place.zoom_x)))
    return Patch(np.asarray(sampled, dtype=np.uint8), x, y)


def tinted(patch: Patch, left_out: BoolImage, place: Placement, pane: tuple[float, float]) -> Patch:
    """A patch of a picture with the True pixels of a mask (H, W) tinted."""
    share = visible(left_out.astype(np.uint8) * 255, place, pane)
    if share is None or share.pixels.shape != patch.pixels.shape[:2]:
        return patch
    weight = share.pixels[..., None].astype(np.float32) * (TINT_SHARE / 255)
    mixed = patch.pixels + weight * (np.array(TINT, np.float32) - patch.pixels)
    return Patch(np.asarray(mixed, dtype=np.uint8), patch.x, patch.y)


def striped(image: ByteImage, place: Placement, pane: tuple[float, float]) -> Patch | None:
    """As `visible`, with stripes where any channel is at 255, or all are at 0.

    A pixel of the screen is striped as soon as a quarter of what it shows is clipped.
    """
    patch = visible(image, place, pane)
    if patch is None:
        return None
    over = 255 - np.asarray(cv2.inRange(image, (0, 0, 0), (254, 254, 254)))
    under = np.asarray(cv2.inRange(image, (0, 0, 0), (0, 0, 0)))
    clipped = visible(np.dstack((over, under)).astype(np.uint8), place, pane)
    assert clipped is not None
    rows, columns = np.ogrid[: patch.pixels.shape[0], : patch.pixels.shape[1]]
    stripes = (rows + patch.y + columns + patch.x) % STRIPE < STRIPE // 2
    pixels = patch.pixels.copy()
    for channel, color in enumerate((OVER, UNDER)):
        pixels[stripes & (clipped.pixels[..., channel] >= 64)] = color
    return Patch(pixels, patch.x, patch.y)


def _span(offset: float, zoom: float, size: int, pane: float) -> tuple[int, int] | None:
    """First and one past the last picture pixel that the pane shows along one axis."""
    first = max(0, math.floor(-offset / zoom))
    last = min(size, math.ceil((pane - offset) / zoom))
    return (first, last) if first < last else None


def _target(span: tuple[int, int], offset: float, zoom: float) -> tuple[int, int]:
    """Where the span starts in the pane and how many pixels it takes there."""
    start, end = (round(offset + zoom * edge) for edge in span)
    return start, max(end - start, 1)


def _halved(part: ByteImage, zoom: float) -> ByteImage:
    """Averaged over squares of whole pixels where several of them make one of the screen.

    What is left to average has a quarter of the pixels or fewer: 1280x1024 on a pane takes 1.9 ms, not 5.5.
    """
    factor = math.floor(1 / zoom)
    if factor < 2 or part.shape[0] % factor or part.shape[1] % factor:
        return part
    size = (part.shape[1] // factor, part.shape[0] // factor)
    return np.asarray(cv2.resize(part, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def _filter(zoom: float) -> int:
    if zoom < NEARLY_WHOLE:
        return cv2.INTER_AREA
    return cv2.INTER_LINEAR if zoom < SHARP_ZOOM else cv2.INTER_NEAREST
