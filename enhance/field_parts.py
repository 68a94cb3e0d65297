"""Fields of view beside each other: with surround between them, or touching; and small ones, insets."""

from __future__ import annotations

import math
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.field import MOST_PARTS
from enhance.field_circle import Points
from enhance.field_outline import (
    LEAST_PART,
    SQUARE,
    Lit,
    around,
    filled,
    is_convex,
    is_sharp,
    is_surround,
    spans_in,
)
from enhance.field_regions import Levels

LEAST_RADIUS: Final = 0.45
"""Of the largest circle in a part: smaller ones are no fields."""
LEAST_AWAY: Final = 0.7
"""Of the sum of two radii: between three circles that touch there is a place as far from the surround."""
MOST_REST: Final = 0.1
"""Of a part made of round fields that touch: what the circles in it leave."""
MOST_HOLE: Final = 0.05
"""Of a part: larger holes lie between fields, smaller ones are highlights and lumens that are dark."""
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
    largest = lit.labels == lit.areas.argmax()
    circles = _inscribed(largest)
    if not 2 <= len(circles) <= MOST_PARTS:
        return [], circles
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


def _inscribed(part: NDArray[np.bool_]) -> Points:
    """(N, 3) middles, x and y, and radii of the largest circles in a part, from the largest one on, of which
    none covers much of another; none where several leave much of the part. One more than MOST_PARTS at
    most."""
    filled_part = _without_holes(part.astype(np.uint8))
    depth = cv2.distanceTransform(filled_part, cv2.DIST_L2, cv2.DIST_MASK_5)
    depth[depth < cv2.dilate(depth, SQUARE)] = 0
    circles = list[tuple[float, float, float]]()
    while len(circles) <= MOST_PARTS:
        _, radius, _, middle = cv2.minMaxLoc(depth)
        if circles and radius < LEAST_RADIUS * circles[0][2]:
            break
        cv2.circle(depth, middle, round(radius), 0, -1)
        if all(math.dist(middle, one[:2]) >= LEAST_AWAY * (radius + one[2]) for one in circles):
            circles.append((middle[0], middle[1], radius))
    if len(circles) == 1:
        return np.array(circles)
    whole = np.count_nonzero(filled_part)
    for x, y, radius in circles:
        cv2.circle(filled_part, (int(x), int(y)), round(radius) + 1, 0, -1)
    is_covered = np.count_nonzero(filled_part) <= MOST_REST * whole
    return np.array(circles if is_covered else []).reshape(-1, 3)


def _without_holes(part: Levels) -> Levels:
    """With what is dark in it, but for holes so large that they may lie between fields."""
    outlines, family = cv2.findContours(part, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    most = MOST_HOLE * np.count_nonzero(part)
    within = (one for one, (*_, parent) in zip(outlines, family[0].tolist(), strict=True) if parent >= 0)
    holes = [one for one in within if cv2.contourArea(one) <= most]
    return np.asarray(cv2.drawContours(part.copy(), holes, -1, 1, cv2.FILLED))
