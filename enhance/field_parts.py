"""Fields of view beside each other: with surround between them, or touching; and small ones, insets."""

from __future__ import annotations

from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.field import MOST_PARTS
from enhance.field_circle import Points
from enhance.field_inscribed import inscribed
from enhance.field_outline import (
    LEAST_PART,
    Lit,
    around,
    filled,
    is_convex,
    is_sharp,
    is_surround,
    spans_in,
)
from enhance.field_regions import Levels

MOST_SHARED: Final = 0.02
"""Of fields that touch: pixels in the convex outlines of several."""
LEAST_INSET: Final = 0.02
"""Of the largest lit part: what is smaller is text or a mark."""
SOLID: Final = 0.92
"""Of its convex outline: so much of an inset is lit; of text less."""
TEXTURED: Final = 4.0
"""Deviation of V in an inset, in grey levels, at least: boxes are even."""
COLORED, ALIKE = 0.03, 0.06
"""Share of a channel in R + G + B: so far from grey is the field, and so near the field an inset."""


def apart(low: Levels, lit: Lit) -> list[Points]:
    """Convex outlines of large lit parts, if there are several, and a surround divides them; else none."""
    if lit.count <= 2:
        return []
    areas = lit.areas
    large = np.flatnonzero(areas >= LEAST_PART * areas.max())
    if not 2 <= len(large) <= MOST_PARTS:
        return []
    hulls = [_hull(lit.labels == one) for one in large]
    return _corners(hulls) if _are_divided(low, lit, hulls, 0.0) else []


def touching(low: Levels, lit: Lit) -> tuple[list[Points], Points]:
    """Convex outlines of the round fields that the largest lit part is made of, and (N, 3) circles inscribed
    in it, middle and radius; no outlines where it is not made of several."""
    circles = inscribed(lit.parts, lit.areas, *low.shape)
    if not 2 <= len(circles) <= MOST_PARTS:
        return [], circles
    largest = lit.labels == lit.areas.argmax()
    height, width = low.shape
    nearest = nearest_of(np.arange(width), np.arange(height)[:, None], circles)
    hulls = [_hull(largest & (nearest == one)) for one in range(len(circles))]
    return (_corners(hulls), circles) if _are_divided(low, lit, hulls, MOST_SHARED) else ([], circles)


def nearest_of(x: NDArray[Any], y: NDArray[Any], circles: Points) -> NDArray[np.intp]:
    """Which of (N, 3) circles each point is nearest to: two that cross part along the line through where
    they do."""
    powers = [(x - at) ** 2 + (y - row) ** 2 - radius**2 for at, row, radius in circles.tolist()]
    return np.asarray(np.argmin(powers, axis=0))


def insets(low: Levels, colors: NDArray[Any], lit: Lit, field: Points) -> list[Points]:
    """Convex outlines of small lit parts beside a field that look as it does; none where the field is grey,
    since marks and menus are, too.

    colors: (h, w, 3) of the small copy. field: its corners.
    """
    if lit.count <= 2:
        return []
    areas = lit.areas
    within = filled(low, field.astype(np.int32)) > 0
    color = _color(colors, within)
    small = np.flatnonzero((areas >= LEAST_INSET * areas.max()) & (areas < LEAST_PART * areas.max()))
    if len(small) == 0 or np.abs(color - 1 / 3).max() < COLORED:
        return []
    found = list[Points]()
    for one in small:
        part = lit.labels == one
        hull = _hull(part)
        whole = filled(low, hull) > 0
        is_solid = areas[one] >= SOLID * whole.sum() and not (whole & within).any()
        if is_solid and low[part].std() >= TEXTURED and np.abs(_color(colors, part) - color).max() <= ALIKE:
            found += _corners([hull])
    return found


def _hull(part: NDArray[np.bool_]) -> NDArray[Any]:
    return cv2.convexHull(cv2.findNonZero(part.view(np.uint8)))


def _corners(hulls: list[NDArray[Any]]) -> list[Points]:
    return [hull[:, 0].astype(np.float64) for hull in hulls]


def _color(colors: NDArray[Any], where: NDArray[np.bool_]) -> Points:
    """Share of each channel in the mean colour."""
    mean = colors[where].mean(axis=0, dtype=np.float64)
    return np.asarray(mean / max(mean.sum(), 1e-9))


def _are_divided(low: Levels, lit: Lit, hulls: list[NDArray[Any]], most: float) -> bool:
    """Whether what lies outside of these is a surround, hardly any of it is within one of them, and these
    share a part of their pixels at `most`."""
    fields = [filled(low, hull) for hull in hulls]
    counts = np.sum(fields, axis=0)
    together = counts > 0
    outside, dark = int((~together).sum()), int((~together & (lit.pixels == 0)).sum())
    is_apart = bool((counts > 1).sum() <= most * together.sum())
    is_apart = is_apart and is_convex(lit.pixels, together.view(np.uint8))
    rim, sharp = np.sum(
        [around(low, lit.pixels, spans_in(one), lit.sharp)[2:] for one in fields], axis=0
    ).tolist()
    return is_apart and is_surround(low, outside, dark) and is_sharp(rim, sharp)
