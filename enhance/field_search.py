"""The search of the field of view: in a small copy of the picture, and then along its rim at full size."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from enhance.field import MOST_PARTS, FieldOfView
from enhance.field_rim import Points, Rim, fitted, left_along_rays
from enhance.image import AnyImage, Picture, full_scale, read_picture

LOW_SIDE: Final = 160
"""Longer side of the small copy, in pixels."""
BRIGHTEST: Final = 64.0
"""Grey levels of V: a brighter corner is no surround."""
NOISIEST: Final = 12.0
"""Deviation of V in a corner, in grey levels: more is structure, not noise."""
STEP, DEVIATIONS, STRAY = 10.0, 5.0, 0.2
"""Above the surround's V by so many grey levels, so many deviations of its noise, and by this share of what
lies between it and the middle of the lit picture, it is field: stray light beside the rim is less."""
MOST_STRAY: Final = 0.5
"""Of the same: what is brighter is field, whatever the noise."""
LEAST_SHADED: Final = 0.1
"""Of the lit field: if it grows by so much with what is as dark as stray light, and ends sharply then, too,
this is tissue in the shade; stray light is a narrow band, or fades."""
FAINT, MOST_FAINT = 0.4, 0.25
"""The way from the surround's V to what no noise reaches, and how many pixels beside a sharp end may be
brighter than that."""
LEAST_SIDE: Final = 16
"""Pixels: smaller pictures are too small for a surround with a rim."""
LEAST_SURROUND: Final = 0.01
"""Of the picture: smaller dark corners are shadow."""
LEAST_FIELD: Final = 0.05
"""Of the picture: with less the picture is too dark to tell."""
LEAST_PART: Final = 0.2
"""Of the largest lit part: others so large are field, too, as of stereo images and of a field that a tool
divides; smaller ones are text and boxes."""
MOST_SWALLOWED: Final = 0.12
"""Of what is dark and touches the border: a shadow on tissue lies within the convex outline, a surround
hardly at all."""
LEAST_DARK: Final = 0.75
"""Of what lies outside the outline; text and boxes are the rest."""
LEAST_SHARP: Final = 0.5
"""Of the outline: there the picture rises by another STEP within two small pixels; a shadow fades."""

MOSTLY, NEVER = 0.5, 2.0
"""How much of a polygon's rim runs as circles and frames do: of parts, as no tool runs so; more than any."""

LEVELS: Final = 256
SQUARE: Final = np.ones((3, 3), np.uint8)
Levels = NDArray[np.uint8]


@dataclass(frozen=True)
class Tones:
    """V of the surround, in grey levels."""

    level: float
    """In the middle."""
    least: float
    """Darker pixels are noise of the surround."""
    threshold: float
    """Darker pixels are surround, lit by stray light at most, or tissue in the shade."""
    most: float
    """No surround is brighter, however noisy."""


@dataclass(frozen=True, eq=False)
class Lit:
    """What of the small copy is brighter than the threshold."""

    threshold: float
    pixels: Levels
    """(h, w), 1 there."""
    labels: NDArray[np.int32]
    """(h, w), of connected parts, but for specks, from 1."""
    count: int
    """One more than these."""


@dataclass(frozen=True, eq=False)
class Outline:
    """Of what is lit in the small copy."""

    corners: Points
    """(N, 2), x and y, of its convex hull; none: it has no surround."""
    is_convex: bool
    """What is dark does not dent it."""


def find_field(image: AnyImage | Picture) -> FieldOfView | None:
    """The field of view of a picture; the whole picture where there is no surround, None where it is too dark
    to tell.

    A surround is dark, even but for noise and text, reaches a corner of the picture, and the convex rest of
    the picture rises sharply from it.

    Raises:
        ImageError: an image that cannot be used.

    Example:
        >>> import numpy as np
        >>> from enhance import find_field
        >>> y, x = np.mgrid[:240, :320] + 0.5
        >>> image = np.where(np.hypot(x - 160, y - 120) < 100, 180, 5).astype(np.uint8)
        >>> [round(value) for value in find_field(image).circle]
        [160, 120, 98]
    """
    picture = image if isinstance(image, Picture) else read_picture(image)
    pixels = picture.pixels
    height, width = pixels.shape[:2]
    whole = FieldOfView(width, height)
    if min(height, width) < LEAST_SIDE:
        return whole
    if pixels.dtype not in (np.uint8, np.uint16, np.float32, np.float64):
        # OpenCV reads no other floats.
        pixels = pixels.astype(np.float32)
    factor = -(-max(height, width) // LOW_SIDE)
    low = _small(pixels, factor)
    tones = _tones(low)
    if tones is None:
        return whole
    lit, threshold = _lit(low, tones.threshold), tones.threshold
    outline = _outline(low, lit)
    if outline is None:
        return None
    scale = np.array([width / low.shape[1], height / low.shape[0]])

    def rim_of(corners: Points) -> Rim:
        return left_along_rays(pixels, (corners + 0.5) * scale, threshold, tones.most, factor)

    parts = tuple(fitted(rim_of(corners), whole, MOSTLY) for corners in _apart(low, lit))
    apart = replace(whole, parts=parts) if parts and not any(one.is_whole for one in parts) else whole
    if len(outline.corners) == 0:
        return apart
    shaded = _shaded(low, tones, outline.corners)
    if shaded is not None:
        outline, threshold = shaded, tones.least
    rim = rim_of(outline.corners)
    if not apart.is_whole:
        field = fitted(rim, whole, NEVER)
        return apart if field.is_whole else field
    return fitted(rim, whole, 0.0 if outline.is_convex else NEVER)


def _small(pixels: AnyImage, factor: int) -> Levels:
    """(h, w) V in grey levels, each pixel from four of the picture, without specks."""
    height, width = pixels.shape[:2]
    size = max(1, width // factor), max(1, height // factor)
    small = _in_levels(np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_LINEAR)))
    if small.ndim == 3:
        red, green, blue = cv2.split(small)
        small = np.asarray(cv2.max(cv2.max(red, green), blue))
    return np.asarray(cv2.medianBlur(small, 3))


def _in_levels(values: AnyImage) -> Levels:
    if values.dtype == np.uint8:
        return values
    return np.rint(values * (255.0 / full_scale(values.dtype))).astype(np.uint8)


def _tones(low: Levels) -> Tones | None:
    """Of the surround, from the darkest corner; None: no corner can be one."""
    level, noise = _darkest_corner(low)
    if level > BRIGHTEST or noise > NOISIEST:
        return None
    beyond = _middle_above(low, level + STEP) - level
    least = level + max(STEP, DEVIATIONS * noise)
    threshold = max(least, level + STRAY * beyond)
    return Tones(level, least, threshold, max(threshold, level + MOST_STRAY * beyond))


@njit(cache=True, error_model="numpy")
def _darkest_corner(low: Levels) -> tuple[float, float]:
    """V in the middle of the darkest corner's pixels, and the deviation by their quartiles."""
    height, width = low.shape
    side = max(2, min(height, width) // 24)
    rows, columns = min(side, height), min(side, width)
    count = rows * columns
    level, brightest, noise = LEVELS, LEVELS, 0.0
    for corner in range(4):
        y0, x0 = (corner // 2) * (height - rows), (corner % 2) * (width - columns)
        counts = np.zeros(LEVELS, np.int32)
        most = 0
        for y in range(y0, y0 + rows):
            for x in range(x0, x0 + columns):
                counts[low[y, x]] += 1
                most = max(most, low[y, x])
        middle = _ranked(counts, count // 2)
        if middle < level or (middle == level and most < brightest):
            level, brightest = middle, most
            noise = 0.74 * (_ranked(counts, 3 * count // 4) - _ranked(counts, count // 4))
    return float(level), noise


@njit(cache=True, error_model="numpy")
def _middle_above(low: Levels, threshold: float) -> float:
    """The median of what is brighter; the threshold where nothing is."""
    # Four histograms in turn, as equal neighbours would wait for each other.
    parts = np.zeros((4, LEVELS), np.int32)
    for y in range(low.shape[0]):
        for x in range(low.shape[1]):
            parts[x & 3, low[y, x]] += 1
    counts, count = np.zeros(LEVELS, np.int32), 0
    for level in range(int(np.floor(threshold)) + 1, LEVELS):
        counts[level] = parts[0, level] + parts[1, level] + parts[2, level] + parts[3, level]
        count += counts[level]
    if count == 0:
        return threshold
    return 0.5 * (_ranked(counts, (count - 1) // 2) + _ranked(counts, count // 2))


@njit(error_model="numpy")
def _ranked(counts: NDArray[np.int32], place: int) -> int:
    """What stands at this place, from 0, of values of which there are so many each."""
    value, before = 0, counts[0]
    while before <= place:
        value += 1
        before += counts[value]
    return value


def _lit(low: Levels, threshold: float) -> Lit:
    lit = np.asarray(cv2.threshold(low, threshold, 1, cv2.THRESH_BINARY)[1], np.uint8)
    count, labels = cv2.connectedComponents(cv2.morphologyEx(lit, cv2.MORPH_OPEN, SQUARE), connectivity=4)
    return Lit(threshold, lit, np.asarray(labels, np.int32), count)


def _outline(low: Levels, lit: Lit) -> Outline | None:
    """Of what is brighter; None: too dark to tell."""
    area, ends = _parts(lit.labels, lit.count)
    if area == 0 or area < LEAST_FIELD * low.size:
        return None
    hull = cv2.convexHull(ends)
    field = _filled(low, hull)
    if not _is_framed(low, lit, field):
        return Outline(np.empty((0, 2)), is_convex=True)
    return Outline(hull[:, 0].astype(np.float64), _is_convex(lit.pixels, field))


def _apart(low: Levels, lit: Lit) -> list[Points]:
    """Convex outlines of large lit parts, if there are several, and a surround divides them; else none."""
    areas = np.bincount(lit.labels.ravel())
    areas[0] = 0
    large = np.flatnonzero(areas >= LEAST_PART * areas.max())
    if not 2 <= len(large) <= MOST_PARTS:
        return []
    hulls = [cv2.convexHull(_parts((lit.labels == one).astype(np.int32), 2)[1]) for one in large]
    fields = [_filled(low, hull) for hull in hulls]
    together = np.asarray(np.sum(fields, axis=0, dtype=np.uint8))
    outside, dark = int((together == 0).sum()), int(((together == 0) & (lit.pixels == 0)).sum())
    is_divided = together.max() == 1 and _is_surround(low, outside, dark) and _is_convex(lit.pixels, together)
    rim, sharp = np.sum([_around(low, lit.pixels, one, lit.threshold)[2:] for one in fields], axis=0).tolist()
    if is_divided and _is_sharp(rim, sharp):
        return [hull[:, 0].astype(np.float64) for hull in hulls]
    return []


def _filled(low: Levels, hull: NDArray[Any]) -> Levels:
    """1 within, 0 without."""
    field = np.zeros_like(low)
    cv2.fillConvexPoly(field, hull, 1)
    return field


def _shaded(low: Levels, tones: Tones, lit: Points) -> Outline | None:
    """The outline with tissue in the shade; None: there is none beyond the outline of what is lit."""
    dark, bright = (np.count_nonzero(low > level) for level in (tones.least, tones.threshold))
    if dark < (1 + LEAST_SHADED) * bright:
        return None
    outline = _outline(low, _lit(low, tones.least))
    if outline is None or len(outline.corners) == 0 or not outline.is_convex:
        return None
    field, before = (_filled(low, corners.astype(np.int32)) for corners in (outline.corners, lit))
    if field.sum() < (1 + LEAST_SHADED) * before.sum():
        return None
    # Two pixels outside, where the outline has moved.
    near = cv2.dilate(field, SQUARE)
    beside = low[(cv2.dilate(near, SQUARE) > near) & (cv2.dilate(before, SQUARE, iterations=4) == 0)]
    faint = beside > tones.level + FAINT * (tones.least - tones.level)
    return outline if len(beside) > 0 and faint.mean() <= MOST_FAINT else None


@njit(cache=True, error_model="numpy")
def _parts(labels: NDArray[np.int32], count: int) -> tuple[int, NDArray[np.int32]]:
    """Pixels of the largest part, 0 where there is none; the (N, 2) ends, x and y, of rows of large ones."""
    height, width = labels.shape
    areas = np.zeros(count, np.int64)
    for y in range(height):
        label, since = labels[y, 0], 0
        for x in range(1, width):
            if labels[y, x] != label:
                areas[label] += x - since
                label, since = labels[y, x], x
        areas[label] += width - since
    areas[0] = 0
    largest = areas.max()
    is_large = areas >= max(LEAST_PART * largest, 1.0)
    ends, found = np.empty((2 * height, 2), np.int32), 0
    for y in range(height if largest > 0 else 0):
        first, last = 0, width - 1
        while first < width and not is_large[labels[y, first]]:
            first += 1
        if first < width:
            while not is_large[labels[y, last]]:
                last -= 1
            ends[found, 0], ends[found + 1, 0] = first, last
            ends[found, 1] = ends[found + 1, 1] = y
            found += 2
    return largest, ends[:found]


def _is_framed(low: Levels, lit: Lit, field: Levels) -> bool:
    """Whether what lies outside the convex field is a surround, not shadow on tissue."""
    outside, dark, rim, sharp = _around(low, lit.pixels, field, lit.threshold)
    return _is_surround(low, outside, dark) and _is_sharp(rim, sharp)


def _is_surround(low: Levels, outside: int, dark: int) -> bool:
    """Of the pixels outside of a field."""
    return outside >= LEAST_SURROUND * low.size and dark >= LEAST_DARK * outside


def _is_sharp(rim: int, sharp: int) -> bool:
    """Of a field's rim."""
    return rim > 0 and sharp >= LEAST_SHARP * rim


def _is_convex(lit: Levels, field: Levels) -> bool:
    """Whether hardly any of what is dark and touches the border lies within the field."""
    # What is dark and touches the border, from a dark frame around it all.
    framed = cv2.copyMakeBorder(lit, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    cv2.floodFill(framed, None, (0, 0), 2)
    reached = framed[1:-1, 1:-1] == 2
    return bool(np.count_nonzero(reached & (field > 0)) <= MOST_SWALLOWED * np.count_nonzero(reached))


@njit(cache=True, error_model="numpy")
def _around(low: Levels, lit: Levels, field: Levels, threshold: float) -> tuple[int, int, int, int]:
    """Pixels outside the field and how many of them are dark; pixels of a ring within it, one away from its
    outline, and how many of them are bright."""
    height, width = low.shape
    spans = np.zeros((height, 2), np.int64)
    outside, dark = 0, 0
    for y in range(height):
        first, end = 0, width
        while first < width and field[y, first] == 0:
            first += 1
        while end > first and field[y, end - 1] == 0:
            end -= 1
        if first < end:
            spans[y, 0], spans[y, 1] = first, end
        outside += width - (end - first)
        for x in range(first):
            dark += 1 - lit[y, x]
        for x in range(end, width):
            dark += 1 - lit[y, x]
    once = _eroded(spans, width)
    twice = _eroded(once, width)
    rim, sharp = 0, 0
    for y in range(height):
        first, end = once[y, 0], once[y, 1]
        inner, outer = twice[y, 0], twice[y, 1]
        if inner >= outer:
            inner = outer = end
        rim += inner - first + end - outer
        for x in range(first, inner):
            sharp += low[y, x] > threshold + STEP
        for x in range(outer, end):
            sharp += low[y, x] > threshold + STEP
    return outside, dark, rim, sharp


@njit(error_model="numpy")
def _eroded(spans: NDArray[np.int64], width: int) -> NDArray[np.int64]:
    """First and after last column of each row, less a pixel all around; what lies beyond the picture counts
    as field."""
    rows = len(spans)
    eroded = np.zeros((rows, 2), np.int64)
    for y in range(rows):
        first, end = 0, width
        for beside in range(max(y - 1, 0), min(y + 2, rows)):
            left, right = spans[beside, 0], spans[beside, 1]
            first = max(first, left + 1 if left > 0 or right == 0 else 0)
            end = min(end, right - 1 if right < width else width)
        if first < end:
            eroded[y, 0], eroded[y, 1] = first, end
    return eroded
