"""Fields of view beside each other: with surround between them, or touching; and small ones, insets."""

from __future__ import annotations

from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.field import MOST_PARTS
from enhance.field_circle import Points
from enhance.field_outline import (
    LEAST_PART,
    Levels,
    Lit,
    around,
    filled,
    is_convex,
    is_sharp,
    is_surround,
    parts_of,
)

LEAST_WAIST: Final = 0.1
"""Of the square root of the lit area: so deep are both dents where fields touch."""
APART: Final = 0.2
"""Of the way around: these dents are at least so far from each other."""
MOST_SHARED: Final = 0.02
"""Of two fields that touch: pixels in the convex outlines of both."""
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
    areas = _areas(lit)
    large = np.flatnonzero(areas >= LEAST_PART * areas.max())
    if not 2 <= len(large) <= MOST_PARTS:
        return []
    hulls = [_hull(lit.labels == one) for one in large]
    return _corners(hulls) if _are_divided(low, lit, hulls, 0.0) else []


def touching(low: Levels, lit: Lit) -> tuple[list[Points], Points | None]:
    """Convex outlines of the two fields that the largest lit part is made of, and the ends of its waist, in
    which these are cut; none where it has none."""
    areas = _areas(lit)
    largest = lit.labels == areas.argmax()
    waist = _waist(largest, LEAST_WAIST * float(np.sqrt(areas.max())))
    if waist is None:
        return [], None
    rows, columns = np.indices(low.shape)
    side = beside(np.stack((columns, rows), axis=2), waist)
    hulls = [_hull(largest & (side > 0)), _hull(largest & (side < 0))]
    return (_corners(hulls), waist) if _are_divided(low, lit, hulls, MOST_SHARED) else ([], None)


def beside(points: NDArray[Any], ends: Points) -> Points:
    """On which side of a line through two points others lie: positive or negative, 0 on it. (..., 2)"""
    (x, y), (to_x, to_y) = ends
    return np.asarray((points[..., 0] - x) * (to_y - y) - (points[..., 1] - y) * (to_x - x))


def insets(low: Levels, colors: NDArray[Any], lit: Lit, field: Points) -> list[Points]:
    """Convex outlines of small lit parts beside a field that look as it does; none where the field is grey,
    since marks and menus are, too.

    colors: (h, w, 3) of the small copy. field: its corners.
    """
    if lit.count <= 2:
        return []
    areas = _areas(lit)
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


def _areas(lit: Lit) -> NDArray[np.int64]:
    """Pixels of each part; none of what is dark."""
    areas = np.bincount(lit.labels.ravel())
    areas[0] = 0
    return areas


def _hull(part: NDArray[np.bool_]) -> NDArray[Any]:
    return cv2.convexHull(parts_of(part.astype(np.int32), 2)[1])


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
    together = np.asarray(np.sum(fields, axis=0, dtype=np.uint8))
    outside, dark = int((together == 0).sum()), int(((together == 0) & (lit.pixels == 0)).sum())
    shared = int((together > 1).sum())
    is_apart = bool(shared <= most * (together > 0).sum()) and is_convex(lit.pixels, together)
    rim, sharp = np.sum([around(low, lit.pixels, one, lit.sharp)[2:] for one in fields], axis=0).tolist()
    return is_apart and is_surround(low, outside, dark) and is_sharp(rim, sharp)


def _waist(part: NDArray[np.bool_], least: float) -> Points | None:
    """The two points, x and y, between which a part is narrowest, of those where its outline dents its convex
    hull most; None: by `least` pixels in fewer than two places that are far from each other."""
    outlines, _ = cv2.findContours(part.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    outline = max(outlines, key=len)[:, 0]
    corners = cv2.convexHull(outline)[:, 0].astype(np.float64)
    sides = np.roll(corners, -1, axis=0) - corners
    lengths = np.maximum(np.hypot(sides[:, 0], sides[:, 1]), 1e-9)
    away = outline[:, None] - corners
    depths = np.abs(sides[:, 0] * away[..., 1] - sides[:, 1] * away[..., 0]) / lengths
    depth, side = depths.min(axis=1), depths.argmin(axis=1)
    deepest = [int(np.where(side == one, depth, -1).argmax()) for one in range(len(corners))]
    places = np.array([one for one in deepest if depth[one] >= least], int)
    steps = np.abs(places[:, None] - places)
    far = np.minimum(steps, len(outline) - steps) >= APART * len(outline)
    if not far.any():
        return None
    across = np.where(far, np.hypot(*np.moveaxis(outline[places][:, None] - outline[places], 2, 0)), np.inf)
    first, second = divmod(int(across.argmin()), len(places))
    return np.asarray(outline[places[[first, second]]], np.float64)
