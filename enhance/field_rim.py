"""The rim of a field of view, measured along rays at full size, and the circle or polygon through it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, Final

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from enhance.field import MOST_CORNERS, FieldOfView, beyond
from enhance.field_circle import Points, circle_through, median, tolerance_of
from enhance.image import AnyImage, BoolImage, full_scale

RAYS: Final = MOST_CORNERS
REACH: Final = 2.5
"""Pixels of the small copy, on either side of the outline, that a ray is looked at."""
RIM: Final = 2.0
"""Pixels within the outline that are half dark."""
DEVIATIONS: Final = 5.0
"""Of the noise at full size that the surround is at most above its middle."""
RUN, MOST_DARK = 5, 1
"""Of so many pixels in a row, at most so many are dark where the field begins: single ones are noise."""
LEAST_ON_CIRCLE: Final = 0.7
"""Of the rays: with fewer the outline is no circle."""
LEAST_HALF: Final = 0.5
"""The same of one of two fields that touch."""
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
LEAST_RISE: Final = 15.0
"""Grey levels from dark to lit, for the width of a rim to be told."""
SOFT_PX, SOFT = 1.0, 0.0044
"""Pixels, and a share of the longer side of the picture: a wider rim that the border of the picture crops is
the edge of a shadow."""
LEAST_FREE: Final = 0.9
"""Of the rays: a field that ends so often within the picture lies free in it."""
BEYOND: Final = 4.0
"""Pixels outside the picture, where the outline goes on: none of the border is left out."""
NEAR: Final = 2.0
"""Pixels: what lies so near the border lies at it."""
FINE: Final = 16
"""Bins of a grey level."""

Samples = NDArray[np.float32]
_ANGLES: Final = np.arange(RAYS) * (2 * np.pi / RAYS)
ALONG: Final = np.stack((np.cos(_ANGLES), np.sin(_ANGLES)), axis=1)

OUTWARD: Final = ALONG[:: RAYS // 8].copy()
"""Of the sides of frames, octagons among them."""


@dataclass(frozen=True, eq=False)
class Rim:
    """Where a field ends."""

    points: Points
    """(N, 2), x and y, less the half-dark rim; corners of the picture that belong to the field are last."""
    cropped: BoolImage
    """(N,) by the border of the picture."""
    lit: BoolImage
    """(N,) up to there, and dark beyond; not so where a ray sees nothing but dark, and of corners."""
    width: float
    """Pixels from dark to lit, the median of what ends within the picture; 0: not told, of a field that lies
    free of the border among others."""


def left_along_rays(pixels: AnyImage, outline: Points, threshold: float, most: float, pixel: int) -> Rim:
    """Where rays from the middle of an outline leave the field.

    Args:
        pixels: (H, W) or (H, W, 3), not float16.
        outline: (N, 2) corners, x and y, a few small pixels off at most.
        threshold: V in grey levels above which a pixel is field, but for noise.
        most: the same whatever the noise.
        pixel: width of a pixel of the small copy that the outline was found in.
    """
    middle, far = _distances(outline)
    colors = pixels if pixels.ndim == 3 else pixels[..., None]
    values = _unrolled(colors, 255 / full_scale(pixels.dtype), middle, far, REACH * pixel)
    threshold = max(threshold, min(_noise_ends(values, int(REACH * pixel)), most))
    height, width = pixels.shape[:2]
    ends = _left(values, middle, far, threshold, pixel, np.array([width, height], np.float64))
    return Rim(*ends, width=0.0 if _are_free(ends[1]) else _width(values, ends[2], pixel))


@njit(cache=True, error_model="numpy")
def _distances(outline: Points) -> tuple[Points, Points]:
    """The middle of a convex outline, and from there to it along each ray."""
    middle, far, count = np.empty(2), np.zeros(RAYS), len(outline)
    for axis in range(2):
        middle[axis] = (outline[:, axis].max() + outline[:, axis].min()) / 2
    for corner in range(count):
        after = corner + 1 if corner + 1 < count else 0
        x, y = outline[corner, 0] - middle[0], outline[corner, 1] - middle[1]
        to_x, to_y = outline[after, 0] - outline[corner, 0], outline[after, 1] - outline[corner, 1]
        # middle + t along = start + u side; cross products by Cramer's rule.
        for ray in range(RAYS):
            below = ALONG[ray, 0] * to_y - ALONG[ray, 1] * to_x
            t = (x * to_y - y * to_x) / below
            u = (x * ALONG[ray, 1] - y * ALONG[ray, 0]) / below
            meets = (t > far[ray]) & (u >= -1e-9) & (u <= 1 + 1e-9)
            far[ray] = t if meets else far[ray]
    return middle, far


@njit(forceinline=True, error_model="numpy")
def _begin(far: float, reach: float) -> float:
    """Of a ray's samples, which are a pixel apart: where the first one lies."""
    return float(np.floor(far - reach) + 0.5)


@njit(cache=True, error_model="numpy")
def _unrolled(pixels: NDArray[Any], scale: float, middle: Points, far: Points, reach: float) -> Samples:
    """(RAYS, n) V along each ray in grey levels, inner end first; negative outside the picture."""
    height, width, channels = pixels.shape
    values = np.empty((RAYS, int(2 * reach) + 1), np.float32)
    for ray in range(RAYS):
        begin = _begin(far[ray], reach)
        for i in range(values.shape[1]):
            x = int(np.floor(middle[0] + (begin + i) * ALONG[ray, 0]))
            y = int(np.floor(middle[1] + (begin + i) * ALONG[ray, 1]))
            values[ray, i] = -1.0
            if 0 <= x < width and 0 <= y < height:
                most = pixels[y, x, 0]
                for channel in range(1, channels):
                    most = max(most, pixels[y, x, channel])
                values[ray, i] = most * scale
    return values


@njit(cache=True, error_model="numpy")
def _noise_ends(values: Samples, outer: int) -> float:
    """V that noise of the surround stays below, from the outer samples of the rays that lie in the picture
    all along; 0 where there are none. Too high where many of these are tissue beyond a rough outline."""
    counts, count = np.zeros(256 * FINE, np.int32), 0
    rays, samples = values.shape
    for ray in range(rays):
        within = True
        for i in range(samples):
            within &= values[ray, i] >= 0
        if within:
            for i in range(samples - outer, samples):
                counts[int(values[ray, i] * FINE + 0.5)] += 1
                count += 1
    if count == 0:
        return 0.0
    level, high = _quantile(counts, count, 0.5), _quantile(counts, count, 0.84)
    return level + DEVIATIONS * (high - level)


@njit(error_model="numpy")
def _quantile(counts: NDArray[np.int32], count: int, share: float) -> float:
    """Of the values in these bins, linear between two of them."""
    place = share * (count - 1)
    first, value, seen = int(place), 0, counts[0]
    while seen <= first:
        value += 1
        seen += counts[value]
    after = value
    while seen <= min(first + 1, count - 1):
        after += 1
        seen += counts[after]
    return (value + (place - first) * (after - value)) / FINE


@njit(cache=True, error_model="numpy")
def _left(
    values: Samples, middle: Points, far: Points, threshold: float, pixel: int, ends: Points
) -> tuple[Points, BoolImage, BoolImage]:
    """`Rim` of what `_unrolled` gives; ends: width and height of the picture."""
    points, cropped, lit = np.empty((RAYS + 4, 2)), np.zeros(RAYS + 4, np.bool_), np.zeros(RAYS + 4, np.bool_)
    for ray in range(RAYS):
        last = _last_lit(values[ray], threshold)
        if last >= 0:
            margin, found = NEAR, _begin(far[ray], REACH * pixel) + last + 0.5
            cropped[ray] = values[ray, min(last + 2, values.shape[1] - 1)] < 0
            lit[ray] = not cropped[ray]
        else:
            # All dark near an outline at the border: the field goes on there, however dim.
            margin, found = float(pixel), far[ray]
            for axis in range(2):
                at = middle[axis] + found * ALONG[ray, axis]
                cropped[ray] |= at < margin or at > ends[axis] - margin
        for axis in range(2):
            within = found if cropped[ray] else found - RIM
            points[ray, axis] = middle[axis] + within * ALONG[ray, axis]
        if cropped[ray]:
            _move_beyond(points[ray], ends, margin)
    count = RAYS
    # A corner of the picture that lies between two rays belongs to the field where both reach the border.
    for corner in range(4):
        points[count, 0], points[count, 1] = ends[0] * (corner // 2), ends[1] * (corner % 2)
        turn = np.arctan2(points[count, 1] - middle[1], points[count, 0] - middle[0]) * (RAYS / (2 * np.pi))
        if cropped[int(np.floor(turn)) % RAYS] and cropped[int(np.ceil(turn)) % RAYS]:
            _move_beyond(points[count], ends, NEAR)
            cropped[count] = True
            count += 1
    return points[:count], cropped[:count], lit[:count]


@njit(cache=True, error_model="numpy")
def _width(values: Samples, lit: BoolImage, pixel: int) -> float:
    """`Rim.width`: of each ray between a fifth and four fifths of the way from the mean of its outer samples
    to that of its inner ones, `pixel` each."""
    widths, count = np.empty(RAYS), 0
    for ray in range(RAYS):
        end = values.shape[1]
        while end > pixel and values[ray, end - 1] < 0:
            end -= 1
        inner, outer = values[ray, :pixel].mean(), values[ray, end - pixel : end].mean()
        if not lit[ray] or inner - outer < LEAST_RISE:
            continue
        first = last = end - 1
        while first > 0 and values[ray, first] <= outer + 0.2 * (inner - outer):
            first -= 1
        last = first
        while last > 0 and values[ray, last] < outer + 0.8 * (inner - outer):
            last -= 1
        widths[count] = first - last
        count += 1
    return median(widths[:count]) if count > 0 else 0.0


@njit(error_model="numpy")
def _last_lit(values: Samples, threshold: float) -> int:
    """The place of the outermost sample that begins a bright run inwards; -1: none does."""
    for last in range(len(values) - 1, -1, -1):
        if values[last] > threshold:
            dark = 0
            for i in range(last - RUN + 1, last):
                dark += i >= 0 and not values[i] > threshold
            if dark <= MOST_DARK or last < RUN:
                return last
    return -1


@njit(error_model="numpy")
def _move_beyond(point: Points, ends: Points, margin: float) -> None:
    """Out of the picture, where it lies so near its border."""
    for axis in range(2):
        if point[axis] < margin:
            point[axis] = -BEYOND
        elif point[axis] > ends[axis] - margin:
            point[axis] = ends[axis] + BEYOND


def cropped_by(rim: Rim, other: BoolImage) -> Rim:
    """Cropped by another field, too: points that lie in it tell nothing of this one."""
    return replace(rim, cropped=rim.cropped | other, lit=rim.lit & ~other)


def fitted(rim: Rim, whole: FieldOfView, least: float) -> FieldOfView:
    """A circle where most points lie on one, without what straight lines cut off it, else the convex hull of
    all, in the picture that is `whole`; all of it where the rim is that of a shadow, or where less than
    `least` of it runs as circles and frames do, unless it lies free of the border."""
    if _fades(rim, whole):
        return whole
    through = _through(rim, whole)
    if through is not None and through[1] >= LEAST_ON_CIRCLE:
        return _cut(replace(whole, circle=through[0]), rim)
    # Too few points tell nothing of their shape.
    arc = 1.0 if through is None else through[1]
    hull = cv2.convexHull(rim.points.astype(np.float32))
    corners = cv2.approxPolyDP(hull, 0.7, closed=True)[:, 0]
    outside = np.hstack((corners < 0, corners > (whole.width, whole.height)))
    within = ~(outside & _next(outside)).any(axis=1)
    sides = (_next(corners) - corners)[within]
    if (arc < LEAST_ARC and _is_shade(sides)) or (least > 0 and _shape(rim, arc, sides) < least):
        return whole
    return _polygon(corners, whole)


def _next(corners: NDArray[Any]) -> NDArray[Any]:
    """Of each corner the one after it; the first one after the last."""
    return np.concatenate((corners[1:], corners[:1]))


def _shape(rim: Rim, arc: float, sides: NDArray[Any]) -> float:
    """Of a rim what runs as circles and frames do: all where it lies free of the border."""
    return 1.0 if _are_free(rim.cropped) else arc + _straight_share(sides)


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
    free = rim.points[~rim.cropped]
    if len(free) < RAYS // 6:
        return None
    *circle, share = circle_through(free)
    x, y, radius = (round(value, 2) for value in circle)
    across, down = (rim.points.max(axis=0) + rim.points.min(axis=0)) / 2
    # Points on a straight line lie on a circle, too: a large one, on either side.
    is_near = radius < max(whole.width, whole.height) and np.hypot(across - x, down - y) < radius
    return (x, y, radius), share if is_near else 0.0


def _are_free(cropped: BoolImage) -> bool:
    """Whether a field lies free of the border, of which parts of its rim are cropped."""
    return int(np.count_nonzero(~cropped)) > LEAST_FREE * RAYS


def _fades(rim: Rim, whole: FieldOfView) -> bool:
    """Whether tissue fades towards it, as in a shadow."""
    return rim.width > SOFT_PX + SOFT * max(whole.width, whole.height)


def _polygon(corners: NDArray[Any], whole: FieldOfView) -> FieldOfView:
    polygon = tuple((round(float(x), 1), round(float(y), 1)) for x, y in corners)
    return FieldOfView(whole.width, whole.height, polygon=polygon)


def around_circle(circle: tuple[float, float, float]) -> Points:
    """(N, 2) corners of a convex outline."""
    return np.asarray(np.array(circle[:2]) + circle[2] * ALONG[:: RAYS // CUT_CORNERS])


def _cut(field: FieldOfView, rim: Rim) -> FieldOfView:
    """A circle, or a polygon where straight lines of lit ends run within it as frames do, such as of a D."""
    assert field.circle is not None
    middle, radius = np.array(field.circle[:2]), field.circle[2]
    levels = _straight_levels(rim.points[:RAYS] - middle, rim.lit, radius)
    if (levels == radius).all():
        return field
    corners = around_circle(field.circle)
    for outward, level in zip(OUTWARD, levels.tolist(), strict=True):
        corners = beyond(corners, -outward, -level - float(middle @ outward))
    return _polygon(corners, replace(field, circle=None))


@njit(cache=True, error_model="numpy")
def _straight_levels(points: Points, lit: BoolImage, radius: float) -> Points:
    """How far from its middle a straight line cuts a circle, in each direction of OUTWARD; the radius where
    none does. points: about the middle."""
    levels, tolerance = np.full(len(OUTWARD), radius), tolerance_of(radius)
    depths, away = np.empty(RAYS), np.sqrt(points[:, 0] ** 2 + points[:, 1] ** 2)
    for turn in range(len(OUTWARD)):
        count = 0
        for ray in range(RAYS):
            depth = points[ray, 0] * OUTWARD[turn, 0] + points[ray, 1] * OUTWARD[turn, 1]
            if depth > AHEAD * away[ray]:
                depths[count] = depth
                count += 1
        level = median(depths[:count]) if count > 0 else radius
        if not 0 < level < radius - max(LEAST_CUT * radius, 2 * tolerance):
            continue
        passing, straight = 0, 0
        for ray in range(RAYS):
            depth = points[ray, 0] * OUTWARD[turn, 0] + points[ray, 1] * OUTWARD[turn, 1]
            if depth * radius > level * away[ray]:
                passing += 1
                straight += lit[ray] and abs(depth - level) <= tolerance
        if straight >= LEAST_STRAIGHT * passing:
            levels[turn] = level
    return levels


def _is_shade(sides: NDArray[Any]) -> bool:
    """Whether (N, 2) sides of a polygon are one straight line that runs as no frame does."""
    whole = sides.sum(axis=0, keepdims=True)
    is_straight = np.hypot(*whole[0]) > STRAIGHT * np.hypot(sides[:, 0], sides[:, 1]).sum()
    return bool(is_straight and _straight_share(whole) == 0)


def _straight_share(sides: NDArray[Any]) -> float:
    """Of the length of (N, 2) sides, what runs as frames do."""
    lengths, turns = np.hypot(sides[:, 0], sides[:, 1]), np.degrees(np.arctan2(sides[:, 1], sides[:, 0])) % 45
    return float(lengths[np.minimum(turns, 45 - turns) <= MOST_SLANT].sum() / max(lengths.sum(), 1.0))
