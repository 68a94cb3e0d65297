"""The circle or polygon through the rim of a field of view."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Any, Final

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from enhance.changed import changed
from enhance.field import MOST_CORNERS, FieldOfView, beyond
from enhance.field_circle import LEAST_FREE, Points, fit_of, median, tolerance_of
from enhance.field_rim import ALONG, RAYS, Rim, are_free
from enhance.image import BoolImage

LEAST_ON_CIRCLE: Final = 0.7
"""Of the rays: with fewer the outline is no circle."""
LEAST_HALF: Final = 0.5
"""The same of one of several fields that touch."""
AHEAD: Final = float(np.cos(np.radians(16)))
"""Of rays so near an upright, level or diagonal one the middle tells how far a circle reaches there."""
LEAST_CUT: Final = 0.04
"""Of the radius: so much nearer than the circle is a straight line that cuts it."""
LEAST_STRAIGHT: Final = 0.6
"""Of the rays that would pass such a line; what ends elsewhere ends in shade."""
CUT_CORNERS: Final = MOST_CORNERS // 2
"""Of a circle that is cut."""
LEAST_ARC: Final = 0.4
"""Of the rays: with so many on a circle the rest may be shade or an instrument beside its rim."""
STRAIGHT: Final = 0.97
"""From end to end of a rim by its length: with more it is one straight line."""
MOST_SLANT: Final = 2.0
"""Degrees of a straight rim from upright, level or half way between, as bars and octagons run; the edge of a
shadow or drape runs anyhow."""
SOFT_PX, SOFT = 1.0, 0.0044
"""Pixels, and a share of the longer side of the picture: a wider rim that the border of the picture crops is
the edge of a shadow."""
FREE: Final = 0.75
"""Of the rim of a field that lies free of the border, what is taken to run as circles and frames do."""
OUTWARD: Final = ALONG[:: RAYS // 8].copy()
"""Of the sides of frames, octagons among them."""


def fitted(rim: Rim, whole: FieldOfView, least: float, round_at: float = LEAST_ON_CIRCLE) -> FieldOfView:
    """A circle where most points lie on one, without what straight lines cut off it, else the convex hull of
    all, in the picture that is `whole`; all of it where the rim is that of a shadow, or where less than
    `least` of it runs as circles and frames do: FREE at least of what lies free of the border.

    round_at: share of the points on a circle from which on they lie on one.
    """
    if _fades(rim, whole):
        return whole
    through = _through(rim, whole)
    if through is not None and through[1] >= round_at:
        return _cut(through[0], rim, whole)
    # Too few points tell nothing of their shape.
    arc = 1.0 if through is None else through[1]
    hull = cv2.convexHull(rim.points.astype(np.float32))
    corners = cv2.approxPolyDP(hull, 0.7, closed=True)[:, 0]
    is_shade, straight, tenths = _runs_of(corners, whole.width, whole.height)
    if (arc < LEAST_ARC and is_shade) or (least > 0 and _shape(rim, arc, straight) < least):
        return whole
    return changed(whole, polygon=tuple([(x, y) for x, y in tenths.tolist()]))


@njit(cache=True, error_model="numpy")
def _runs_of(corners: NDArray[Any], width: int, height: int) -> tuple[bool, float, Points]:
    """Of the (N, 2) corners of an outline in a picture of this size: whether its sides, but for those outside
    the picture, are one straight line that runs as no frame does; what of their length runs as frames do; and
    the corners to tenths."""
    length, straight, across, down = 0.0, 0.0, 0.0, 0.0
    tenths = np.empty(corners.shape)
    for corner in range(len(corners)):
        for axis in range(2):
            # Ten times a float32 is exact in a float64.
            tenths[corner, axis] = np.rint(np.float64(corners[corner, axis]) * 10) / 10
        after = corner + 1 if corner + 1 < len(corners) else 0
        x, y, to_x, to_y = corners[corner, 0], corners[corner, 1], corners[after, 0], corners[after, 1]
        if max(x, to_x) < 0 or max(y, to_y) < 0 or min(x, to_x) > width or min(y, to_y) > height:
            continue
        side = np.hypot(to_x - x, to_y - y)
        length, across, down = length + side, across + to_x - x, down + to_y - y
        straight += side if _is_straight(to_x - x, to_y - y) else 0.0
    is_line = np.hypot(across, down) > STRAIGHT * length
    return is_line and not _is_straight(across, down), straight / max(length, 1.0), tenths


@njit(error_model="numpy")
def _is_straight(across: float, down: float) -> bool:
    """As frames run."""
    turn = np.degrees(np.arctan2(down, across)) % 45
    return bool(min(turn, 45 - turn) <= MOST_SLANT)


def _shape(rim: Rim, arc: float, straight: float) -> float:
    """Of a rim what runs as circles and frames do."""
    return max(arc + straight, FREE if are_free(rim.cropped) else 0.0)


def share_on_circle(rim: Rim, whole: FieldOfView) -> float:
    """Of what ends within the picture."""
    through = _through(rim, whole)
    return 0.0 if through is None else through[1]


def are_circles(rims: list[Rim], whole: FieldOfView) -> bool:
    """Whether rims lie on circles, one of them half in the shade perhaps, none about another's middle."""
    through = [_through(rim, whole) for rim in rims]
    found = [one for one in through if one is not None]
    shares = sorted(share for _, share in found)
    if len(found) < len(rims) or shares[0] < LEAST_HALF or shares[1] < LEAST_ON_CIRCLE:
        return False
    circles = [circle for circle, _ in found]
    return all(
        math.dist(one[:2], other[:2]) > max(one[2], other[2]) for one, other in combinations(circles, 2)
    )


def _through(rim: Rim, whole: FieldOfView) -> tuple[tuple[float, float, float], float] | None:
    """The circle through what ends within the picture, and the share of these points on it, 0 where it is
    none of the picture; None: too few to tell."""
    count, (across, down), (x, y, radius), share = fit_of(rim.points, rim.cropped)
    if count < LEAST_FREE:
        return None
    # Points on a straight line lie on a circle, too: a large one, on either side.
    is_near = radius < max(whole.width, whole.height) and math.hypot(across - x, down - y) < radius
    return (x, y, radius), share if is_near else 0.0


def _fades(rim: Rim, whole: FieldOfView) -> bool:
    """Whether tissue fades towards it, as in a shadow."""
    return rim.width > SOFT_PX + SOFT * max(whole.width, whole.height)


def around_circle(circle: tuple[float, float, float]) -> Points:
    """(N, 2) corners of a convex outline."""
    return np.asarray(np.array(circle[:2]) + circle[2] * ALONG[:: RAYS // CUT_CORNERS])


def _cut(circle: tuple[float, float, float], rim: Rim, whole: FieldOfView) -> FieldOfView:
    """A circle, or a polygon where straight lines of lit ends run within it as frames do, such as of a D."""
    is_cut, levels = _straight_levels(rim.points, rim.lit, *circle)
    if not is_cut:
        return changed(whole, circle=circle)
    corners, middle = around_circle(circle), np.array(circle[:2])
    for outward, level in zip(OUTWARD, levels.tolist(), strict=True):
        corners = beyond(corners, -outward, -level - float(middle @ outward))
    return changed(whole, polygon=tuple([(round(x, 1), round(y, 1)) for x, y in corners.tolist()]))


@njit(cache=True, error_model="numpy")
def _straight_levels(
    points: Points, lit: BoolImage, middle_x: float, middle_y: float, radius: float
) -> tuple[bool, Points]:
    """Whether straight lines cut a circle, and how far from its middle, in each direction of OUTWARD; the
    radius where none does."""
    levels, tolerance, is_cut = np.full(len(OUTWARD), radius), tolerance_of(radius), False
    depths, away, x, y = np.empty(RAYS), np.empty(RAYS), np.empty(RAYS), np.empty(RAYS)
    for ray in range(RAYS):
        x[ray], y[ray] = points[ray, 0] - middle_x, points[ray, 1] - middle_y
        away[ray] = np.sqrt(x[ray] ** 2 + y[ray] ** 2)
    for turn in range(len(OUTWARD)):
        count = 0
        for ray in range(RAYS):
            depth = x[ray] * OUTWARD[turn, 0] + y[ray] * OUTWARD[turn, 1]
            if depth > AHEAD * away[ray]:
                depths[count] = depth
                count += 1
        level = median(depths[:count]) if count > 0 else radius
        if not 0 < level < radius - max(LEAST_CUT * radius, 2 * tolerance):
            continue
        passing, straight = 0, 0
        for ray in range(RAYS):
            depth = x[ray] * OUTWARD[turn, 0] + y[ray] * OUTWARD[turn, 1]
            if depth * radius > level * away[ray]:
                passing += 1
                straight += lit[ray] and abs(depth - level) <= tolerance
        if straight >= LEAST_STRAIGHT * passing:
            levels[turn], is_cut = level, True
    return is_cut, levels
