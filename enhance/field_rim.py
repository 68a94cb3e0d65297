"""The rim of a field of view, measured along rays at full size."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numba.extending import register_jitable
from numpy.typing import NDArray

from enhance.field import MOST_CORNERS
from enhance.field_circle import Points, median
from enhance.image import AnyImage, BoolImage, full_scale
from enhance.prefetch import fetch_line
from enhance.wide_vectors import wide_vectors

RAYS: Final = MOST_CORNERS
REACH: Final = 2.5
"""Pixels of the small copy, on either side of the outline, that a ray is looked at."""
RIM: Final = 2.0
"""Pixels within the outline that are half dark."""
DEVIATIONS: Final = 5.0
"""Of the noise at full size that the surround is at most above its middle."""
RUN, MOST_DARK = 5, 1
"""Of so many pixels in a row, at most so many are dark where the field begins: single ones are noise."""
LEAST_RISE: Final = 15.0
"""Grey levels from dark to lit, for the width of a rim to be told."""
LEAST_FREE: Final = 0.9
"""Of the rays: a field that ends so often within the picture lies free in it."""
BEYOND: Final = 4.0
"""Pixels outside the picture, where the outline goes on: none of the border is left out."""
DOWN: Final = 0.2
"""Of the way from the surround's V to where a faint rim begins: what is darker is surround."""
MOST_IN_THE_DARK: Final = 0.25
"""Of the rays: with more that see nothing but dark the field goes on in the dark."""
NEAR: Final = 2.0
"""Pixels: what lies so near the border lies at it."""
FINE: Final = 16
"""Bins of a grey level."""
BESIDE_RAYS: Final = 8
"""Of so many rays, one tells what lies along a circle."""

Samples = NDArray[np.float32]
_ANGLES: Final = np.arange(RAYS) * (2 * np.pi / RAYS)
ALONG: Final = np.stack((np.cos(_ANGLES), np.sin(_ANGLES)), axis=1)


class Rim(NamedTuple):
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
    is_noisy: bool
    """What lies beyond varies more than noise of a surround does: stray light, or field."""
    is_dark: bool
    """Many rays see nothing but dark: the field goes on beyond them, perhaps."""


def left_along_rays(
    pixels: AnyImage,
    corners: Points,
    size: tuple[int, int],
    threshold: float,
    most: float,
    pixel: int,
    *,
    is_faint: bool = False,
) -> Rim:
    """Where rays from the middle of an outline leave the field.

    Args:
        pixels: (H, W) or (H, W, 3), not float16.
        corners: (N, 2) of the outline, x and y in pixels of a small copy, a few off at most.
        size: of the small copy, height and width.
        threshold: V in grey levels above which a pixel is field, but for noise.
        most: the same whatever the noise.
        pixel: width of a pixel of the small copy.
        is_faint: the rim is hardly brighter than the surround; it is no wider than what lies between these.
    """
    colors = pixels if pixels.ndim == 3 else pixels[..., None]
    values, middle, far = _seen_along(colors, 255 / full_scale(pixels.dtype), corners, size, REACH * pixel)
    height, width = pixels.shape[:2]
    return _ends_of(values, middle, far, threshold, most, pixel, width, height, is_faint)


@njit(error_model="numpy")
def _at_full_size(corners: Points, size: tuple[int, int], width: int, height: int) -> Points:
    """(N, 2) middles of pixels of a small copy of this size in the picture, which is of the other."""
    points = np.empty_like(corners)
    across, down = width / size[1], height / size[0]
    for corner in range(len(corners)):
        points[corner, 0] = (corners[corner, 0] + 0.5) * across
        points[corner, 1] = (corners[corner, 1] + 0.5) * down
    return points


@njit(cache=True, error_model="numpy")
def _seen_along(
    pixels: NDArray[Any], scale: float, corners: Points, size: tuple[int, int], reach: float
) -> tuple[Samples, Points, Points]:
    """`_unrolled`, and `_distances`."""
    middle, far = _distances(_at_full_size(corners, size, pixels.shape[1], pixels.shape[0]))
    return _unrolled(pixels, scale, middle, far, reach), middle, far


@njit(cache=True, error_model="numpy")
def _ends_of(
    values: Samples,
    middle: Points,
    far: Points,
    threshold: float,
    most: float,
    pixel: int,
    width: int,
    height: int,
    is_faint: bool,
) -> Rim:
    """Of a picture of this size."""
    noise = _noise_ends(values, int(REACH * pixel))
    threshold = max(threshold, min(noise, most))
    points, cropped, lit = _left(values, middle, far, threshold, pixel, np.array([width, height], np.float64))
    wide = 0.0
    if not are_free(cropped):
        wide = _width(values, lit, pixel)
        if is_faint:
            wide = min(wide, _fall(values, threshold))
    in_the_dark = 0
    for ray in range(RAYS):
        in_the_dark += not (lit[ray] or cropped[ray])
    return Rim(points, cropped, lit, wide, noise > most, in_the_dark > MOST_IN_THE_DARK * RAYS)


@njit(error_model="numpy")
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


@njit(error_model="numpy")
def _unrolled(pixels: NDArray[Any], scale: float, middle: Points, far: Points, reach: float) -> Samples:
    """(RAYS, n) V along each ray in grey levels, inner end first; negative outside the picture."""
    height, width, channels = pixels.shape
    values = np.empty((RAYS, int(2 * reach) + 1), np.float32)
    # Of a ray and the next one, whose pixels are asked for meanwhile.
    places = np.empty((2, 2, values.shape[1]), np.intp)
    _find_places(middle, _begin(far[0], reach), 0, places[0])
    for ray in range(RAYS):
        here, ahead = places[ray % 2], places[1 - ray % 2]
        if ray + 1 < RAYS:
            _find_places(middle, _begin(far[ray + 1], reach), ray + 1, ahead)
        for i in range(values.shape[1]):
            fetch_line(pixels, (ahead[1, i] * width + ahead[0, i]) * channels)  # type: ignore[call-arg]
            x, y = here[0, i], here[1, i]
            values[ray, i] = -1.0
            if 0 <= x < width and 0 <= y < height:
                most = pixels[y, x, 0]
                for channel in range(1, channels):
                    most = max(most, pixels[y, x, channel])
                values[ray, i] = most * scale
    return values


@njit(error_model="numpy")
def _find_places(middle: Points, begin: float, ray: int, places: NDArray[np.intp]) -> None:
    """(2, n) x and y of the pixels along a ray, the first one so far from the middle."""
    wide_vectors()
    for axis in range(2):
        start, step = middle[axis], ALONG[ray, axis]
        for i in range(places.shape[1]):
            places[axis, i] = int(np.floor(start + (begin + i) * step))


@njit(error_model="numpy")
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


@njit(error_model="numpy")
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
def _fall(values: Samples, threshold: float) -> float:
    """Pixels from where rays leave the field to where the mean V of all is nearly as dark as it gets."""
    samples = values.shape[1]
    means, counts = np.zeros(samples), np.zeros(samples)
    for ray in range(RAYS):
        last = _last_lit(values[ray], threshold)
        for i in range(last + 1, samples if last >= 0 else 0):
            if values[ray, i] >= 0:
                means[i - last] += values[ray, i]
                counts[i - last] += 1
    darkest = threshold
    for away in range(1, samples):
        means[away] = means[away] / counts[away] if counts[away] > 0 else threshold
        darkest = min(darkest, means[away])
    for away in range(1, samples):
        if means[away] <= darkest + DOWN * (threshold - darkest):
            return float(away)
    return float(samples)


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


@njit(cache=True, error_model="numpy")
def dim_beside(
    low: NDArray[np.uint8], factor: int, circle: tuple[float, float, float], most: float
) -> tuple[int, int]:
    """Pixels of a small copy, by this factor, along a circle of the picture, and how many of them are no
    brighter than `most`."""
    height, width = low.shape
    seen, dim = 0, 0
    for ray in range(0, RAYS, BESIDE_RAYS):
        x = int((circle[2] * ALONG[ray, 0] + circle[0]) / factor)
        y = int((circle[2] * ALONG[ray, 1] + circle[1]) / factor)
        if 0 <= x < width and 0 <= y < height:
            seen += 1
            dim += low[y, x] <= most
    return seen, dim


def cropped_by(rim: Rim, other: BoolImage) -> Rim:
    """Cropped by another field, too: points that lie in it tell nothing of this one."""
    return rim._replace(cropped=rim.cropped | other, lit=rim.lit & ~other)


@register_jitable
def are_free(cropped: BoolImage) -> bool:
    """Whether a field lies free of the border, of which parts of its rim are cropped."""
    return bool(len(cropped) - np.count_nonzero(cropped) > LEAST_FREE * RAYS)
