"""What of a small copy of the picture is lit, and whether a surround lies around it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, NamedTuple

import cv2
import numpy as np
from numba import njit
from numba.extending import register_jitable
from numpy.typing import NDArray

from enhance.field_circle import Points
from enhance.field_hull import hull_of, within
from enhance.field_regions import (
    Levels,
    Numbers,
    Runs,
    connected,
    dark_beside_border,
    drawn,
    ends_of,
    lit_parts,
)

STEP: Final = 10.0
"""Grey levels that a field is above the surround at least, and above the threshold within two small pixels
of a sharp rim."""
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
LEAST_DENTS: Final = 0.015
"""Of the convex outline: with less that is dark in it, it is no outline of two fields that touch."""
LEAST_DARK: Final = 0.75
"""Of what lies outside the outline; text and boxes are the rest."""
LEAST_SHARP: Final = 0.5
"""Of the outline: there the picture rises by another STEP within two small pixels; a shadow fades."""

SQUARE: Final = np.ones((3, 3), np.uint8)


@dataclass(frozen=True, eq=False)
class Lit:
    """What of the small copy is brighter than the threshold."""

    threshold: float
    sharp: float
    """Within two small pixels of a sharp rim it is brighter than this."""
    pixels: Levels
    """(h, w), 1 there."""
    parts: Runs
    """That are connected, but for specks."""
    areas: NDArray[np.int64]
    """Pixels of each of these; 0 of none."""

    @property
    def count(self) -> int:
        """One more than there are parts."""
        return len(self.areas)

    @cached_property
    def labels(self) -> Numbers:
        """(h, w) the number of each pixel's part, 0 where there is none."""
        return drawn(self.parts, *self.pixels.shape)


class Outline(NamedTuple):
    """Of what is lit in the small copy."""

    corners: Points
    """(N, 2), x and y, of its convex hull; none: it has no surround."""
    is_convex: bool
    """What is dark does not dent it."""
    is_dented: bool
    """What is dark and touches the border takes some of it, be it little."""


def lit_above(low: Levels, threshold: float, step: float = STEP) -> tuple[Lit, Outline | None]:
    """And its outline; None: too dark to tell.

    step: from the threshold to what lies within a sharp rim.
    """
    sharp = sharp_from(threshold, step)
    lit, is_told, outline = lit_in(low, threshold, sharp)
    return Lit(threshold, sharp, *lit), outline if is_told else None


@register_jitable
def sharp_from(threshold: float, step: float = STEP) -> float:
    """`Lit.sharp`."""
    return threshold + step


@njit(cache=True, error_model="numpy")
def lit_in(
    low: Levels, threshold: float, sharp_level: float
) -> tuple[tuple[Levels, Runs, NDArray[np.int64]], bool, Outline]:
    """`lit_parts`, whether it is bright enough to tell, and the outline."""
    found = lit, parts, areas = lit_parts(low, threshold)
    area = areas.max()
    if area == 0 or area < LEAST_FIELD * low.size:
        return found, False, Outline(np.empty((0, 2)), True, False)
    hull = hull_of(ends_of(parts, areas >= LEAST_PART * area))
    field = within(hull, low.shape[0], low.shape[1])
    outside, dark, rim, sharp = around(low, lit, field, sharp_level)
    if not (is_surround(low, outside, dark) and is_sharp(rim, sharp)):
        return found, True, Outline(np.empty((0, 2)), True, False)
    dents, reached = dark_beside_border(lit, field, np.arange(low.shape[0] + 1, dtype=np.int32))
    is_convex, is_dented = dents <= MOST_SWALLOWED * reached, dents >= LEAST_DENTS * (low.size - outside)
    return found, True, Outline(hull.astype(np.float64), is_convex, is_dented)


def filled(low: Levels, hull: NDArray[Any]) -> Levels:
    """1 within, 0 without."""
    field = np.zeros_like(low)
    cv2.fillConvexPoly(field, hull, 1)
    return field


@njit(cache=True, error_model="numpy")
def spans_in(field: Levels) -> Numbers:
    """(h, 2) of a field of one span in each row, as `within`."""
    height, width = field.shape
    spans = np.zeros((height, 2), np.int32)
    for y in range(height):
        first, end = 0, width
        while first < width and field[y, first] == 0:
            first += 1
        while end > first and field[y, end - 1] == 0:
            end -= 1
        if first < end:
            spans[y, 0], spans[y, 1] = first, end
    return spans


@register_jitable
def is_surround(low: Levels, outside: int, dark: int) -> bool:
    """Of the pixels outside of a field."""
    return outside >= LEAST_SURROUND * low.size and dark >= LEAST_DARK * outside


@register_jitable
def is_sharp(rim: int, sharp: int) -> bool:
    """Of a field's rim."""
    return rim > 0 and sharp >= LEAST_SHARP * rim


@njit(cache=True, error_model="numpy")
def is_convex(lit: Levels, field: Levels) -> bool:
    """Whether hardly any of what is dark and touches the border lies within the field, which is 1."""
    spans, lines, _ = connected(field, 1)
    dents, reached = dark_beside_border(lit, spans, lines)
    return dents <= MOST_SWALLOWED * reached


@njit(cache=True, error_model="numpy")
def around(low: Levels, lit: Levels, spans: Numbers, sharp_level: float) -> tuple[int, int, int, int]:
    """Pixels outside the field and how many of them are dark; pixels of a ring within it, one away from its
    outline, and how many of them are brighter than `sharp_level`. spans: `within` of the field."""
    height, width = low.shape
    outside, dark = 0, 0
    for y in range(height):
        first, end = spans[y, 0], spans[y, 1]
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
            sharp += low[y, x] > sharp_level
        for x in range(outer, end):
            sharp += low[y, x] > sharp_level
    return outside, dark, rim, sharp


@njit(error_model="numpy")
def _eroded(spans: Numbers, width: int) -> Numbers:
    """First and after last column of each row, less a pixel all around; what lies beyond the picture counts
    as field."""
    rows = len(spans)
    eroded = np.zeros((rows, 2), np.int32)
    for y in range(rows):
        first, end = 0, width
        for beside in range(max(y - 1, 0), min(y + 2, rows)):
            left, right = spans[beside, 0], spans[beside, 1]
            first = max(first, left + 1 if left > 0 or right == 0 else 0)
            end = min(end, right - 1 if right < width else width)
        if first < end:
            eroded[y, 0], eroded[y, 1] = first, end
    return eroded
