"""The rim of a field of view, measured along rays at full size, and the circle or polygon through it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from enhance.field import MOST_CORNERS, FieldOfView, beyond
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
LEAST_FREE: Final = 0.9
"""Of the rays: a field that ends so often within the picture lies free in it."""
CIRCLE_TOLERANCE: Final = 1.5
"""Pixels, or so many thousandths of the radius where that is more, that a point may lie off a circle."""
BEYOND: Final = 4.0
"""Pixels outside the picture, where the outline goes on: none of the border is left out."""
NEAR: Final = 2.0
"""Pixels: what lies so near the border lies at it."""
FINE: Final = 16
"""Bins of a grey level."""

Points = NDArray[np.float64]
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


def left_along_rays(pixels: AnyImage, outline: Points, threshold: float, most: float, pixel: int) -> Rim:
    """Where rays from the middle of an outline leave the field.

    Args:
        pixels: (H, W) or (H, W, 3), not float16.
        outline: (N, 2) corners, x and y, a few small pixels off at most.
        threshold: V in grey levels above which a pixel is field, but for noise.
        most: the same whatever the noise.
        pixel: width of a pixel of the small copy that the outline was found in.
    """
    middle = (outline.max(axis=0) + outline.min(axis=0)) / 2
    far = _distances(middle, outline)
    colors = pixels if pixels.ndim == 3 else pixels[..., None]
    values = _unrolled(colors, 255 / full_scale(pixels.dtype), middle, far, REACH * pixel)
    threshold = max(threshold, min(_noise_ends(values, int(REACH * pixel)), most))
    height, width = pixels.shape[:2]
    return Rim(*_left(values, middle, far, threshold, pixel, np.array([width, height], np.float64)))


@njit(cache=True, error_model="numpy")
def _distances(middle: Points, outline: Points) -> Points:
    """From a point within a convex outline to it, along each ray."""
    far, count = np.zeros(RAYS), len(outline)
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
    return far


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


def fitted(rim: Rim, whole: FieldOfView, least: float) -> FieldOfView:
    """A circle where most points lie on one, without what straight lines cut off it, else the convex hull of
    all, in the picture that is `whole`; all of it where the hull ends in shade, or where less than
    `least` of its rim runs as circles and frames do, unless it lies free of the border."""
    free, arc = rim.points[~rim.cropped], 1.0
    if len(free) >= RAYS // 6:
        *circle, share = _circle(free)
        x, y, radius = (round(value, 2) for value in circle)
        across, down = (rim.points.max(axis=0) + rim.points.min(axis=0)) / 2
        # Points on a straight line lie on a circle, too: a large one, on either side.
        is_round = radius < max(whole.width, whole.height) and np.hypot(across - x, down - y) < radius
        arc = share if is_round else 0.0
        if arc >= LEAST_ON_CIRCLE:
            return _cut(FieldOfView(whole.width, whole.height, circle=(x, y, radius)), rim)
    hull = cv2.convexHull(rim.points.astype(np.float32))
    corners = cv2.approxPolyDP(hull, 0.7, closed=True)[:, 0]
    outside = np.hstack((corners < 0, corners > (whole.width, whole.height)))
    within = ~(outside & np.roll(outside, -1, axis=0)).any(axis=1)
    sides = (np.roll(corners, -1, axis=0) - corners)[within]
    shape = 1.0 if len(free) > LEAST_FREE * RAYS else arc + _straight_share(sides)
    if (arc < LEAST_ARC and _is_shade(sides)) or shape < least:
        return whole
    return _polygon(corners, whole)


def _polygon(corners: NDArray[Any], whole: FieldOfView) -> FieldOfView:
    polygon = tuple((round(float(x), 1), round(float(y), 1)) for x, y in corners)
    return FieldOfView(whole.width, whole.height, polygon=polygon)


def _cut(field: FieldOfView, rim: Rim) -> FieldOfView:
    """A circle, or a polygon where straight lines of lit ends run within it as frames do, such as of a D."""
    assert field.circle is not None
    middle, radius = np.array(field.circle[:2]), field.circle[2]
    levels = _straight_levels(rim.points[:RAYS] - middle, rim.lit, radius)
    if (levels == radius).all():
        return field
    corners = middle + radius * ALONG[:: RAYS // CUT_CORNERS]
    for outward, level in zip(OUTWARD, levels.tolist(), strict=True):
        corners = beyond(corners, -outward, -level - float(middle @ outward))
    return _polygon(corners, replace(field, circle=None))


@njit(cache=True, error_model="numpy")
def _straight_levels(points: Points, lit: BoolImage, radius: float) -> Points:
    """How far from its middle a straight line cuts a circle, in each direction of OUTWARD; the radius where
    none does. points: about the middle."""
    levels, tolerance = np.full(len(OUTWARD), radius), _tolerance(radius)
    depths, away = np.empty(RAYS), np.sqrt(points[:, 0] ** 2 + points[:, 1] ** 2)
    for turn in range(len(OUTWARD)):
        count = 0
        for ray in range(RAYS):
            depth = points[ray, 0] * OUTWARD[turn, 0] + points[ray, 1] * OUTWARD[turn, 1]
            if depth > AHEAD * away[ray]:
                depths[count] = depth
                count += 1
        level = _median(depths[:count]) if count > 0 else radius
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


@njit(error_model="numpy")
def _tolerance(radius: float) -> float:
    return float(max(CIRCLE_TOLERANCE, CIRCLE_TOLERANCE * radius / 1000))


def _is_shade(sides: NDArray[Any]) -> bool:
    """Whether (N, 2) sides of a polygon are one straight line that runs as no frame does."""
    whole = sides.sum(axis=0, keepdims=True)
    is_straight = np.hypot(*whole[0]) > STRAIGHT * np.hypot(sides[:, 0], sides[:, 1]).sum()
    return bool(is_straight and _straight_share(whole) == 0)


def _straight_share(sides: NDArray[Any]) -> float:
    """Of the length of (N, 2) sides, what runs as frames do."""
    lengths, turns = np.hypot(sides[:, 0], sides[:, 1]), np.degrees(np.arctan2(sides[:, 1], sides[:, 0])) % 45
    return float(lengths[np.minimum(turns, 45 - turns) <= MOST_SLANT].sum() / max(lengths.sum(), 1.0))


@njit(cache=True, error_model="numpy")
def _circle(points: Points) -> tuple[float, float, float, float]:
    """Middle, x and y, and radius through most of the points (Kasa, IEEE Trans. Instrum. Meas. 25, 1976; the
    worst are left out again and again), and the share of points on it."""
    apart, most = np.zeros(len(points)), 0.0
    x, y, radius, tolerance = 0.0, 0.0, 0.0, 0.0
    for _ in range(6):
        x, y, radius = _kasa(points, apart, most)
        for i in range(len(points)):
            apart[i] = abs(np.sqrt((points[i, 0] - x) ** 2 + (points[i, 1] - y) ** 2) - radius)
        tolerance = _tolerance(radius)
        most = max(tolerance, 2 * _median(apart))
    near = 0
    for i in range(len(points)):
        near += apart[i] <= tolerance
    return x, y, radius, near / len(points)


@njit(error_model="numpy")
def _median(values: Points) -> float:
    """Of at least one value (Hoare, CACM 4(7), 1961); numba's own takes seconds to compile."""
    rest = values.copy()
    place, low, high = len(rest) // 2, 0, len(rest) - 1
    while low < high:
        pivot, i, j = rest[(low + high) // 2], low, high
        while i <= j:
            while rest[i] < pivot:
                i += 1
            while rest[j] > pivot:
                j -= 1
            if i <= j:
                rest[i], rest[j] = rest[j], rest[i]
                i, j = i + 1, j - 1
        low, high = (i if place >= i else low), (j if place <= j else high)
        if j < place < i:
            break
    below = rest[place]
    if len(rest) % 2 == 0:
        below = rest[0]
        for i in range(place):
            below = max(below, rest[i])
    return float(0.5 * (below + rest[place]))


@njit(error_model="numpy")
def _kasa(points: Points, apart: Points, most: float) -> tuple[float, float, float]:
    """Middle and radius of the circle through the points that lie so far apart at most; radius 0 where these
    lie on a line.

    About their mean the third normal equation, which gives the radius, stands alone.
    """
    count, x, y = 0, 0.0, 0.0
    for i in range(len(points)):
        if apart[i] <= most:
            count, x, y = count + 1, x + points[i, 0], y + points[i, 1]
    x, y = x / count, y / count
    xx, xy, yy, right_x, right_y = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(points)):
        if apart[i] <= most:
            across, down = points[i, 0] - x, points[i, 1] - y
            square = across * across + down * down
            xx, xy, yy = xx + across * across, xy + across * down, yy + down * down
            right_x, right_y = right_x + across * square, right_y + down * square
    below = 2 * (xx * yy - xy * xy)
    if below <= 0:
        return x, y, 0.0
    to_x, to_y = (yy * right_x - xy * right_y) / below, (xx * right_y - xy * right_x) / below
    return x + to_x, y + to_y, np.sqrt((xx + yy) / count + to_x**2 + to_y**2)
