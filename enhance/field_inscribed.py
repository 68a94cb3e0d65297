"""The largest circles in what is lit of a small copy of the picture: round fields that touch are made of
such."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enhance.field import MOST_PARTS
from enhance.field_circle import Points
from enhance.field_regions import Levels, Runs, areas_of, connected, touching_border
from enhance.wide_vectors import wide_vectors

LEAST_RADIUS = 0.45
"""Of the largest circle in a part: smaller ones are no fields."""
LEAST_AWAY = 0.7
"""Of the sum of two radii: between three circles that touch there is a place as far from the surround."""
MOST_REST = 0.1
"""Of a part made of round fields that touch: what the circles in it leave."""
MOST_HOLE = 0.05
"""Of a part: larger holes lie between fields, smaller ones are highlights and lumens that are dark."""
SLACK = 0.85
"""Of the least radius and distance, in a copy of half the size: where there are not even two such circles, as
in most fields that tissue in the shade dents, none are looked for in full."""
FAR = 200
"""Pixels: no small copy is so wide, and the square of this and that of a side together are of 16 bits."""

Squares = NDArray[np.uint16]


@njit(cache=True, error_model="numpy")
def inscribed(parts: Runs, areas: NDArray[np.int64], height: int, width: int) -> Points:
    """(N, 3) middles, x and y, and radii of the largest circles in the largest part, from the largest one on,
    of which none covers much of another, one more than MOST_PARTS at most; none where there are not several,
    or these leave much of the part.

    parts: of a small copy of this size; areas: `areas_of` these.
    """
    part = without_holes(parts, int(areas.argmax()), height, width)
    if len(_circles_in(depths_in(halved(part)), 2, SLACK)) < 2:
        return np.empty((0, 3))
    circles = _circles_in(depths_in(part), MOST_PARTS + 1, 1.0)
    is_made_of_them = len(circles) > 1 and _rest(part, circles) <= MOST_REST * part.sum()
    return circles if is_made_of_them else np.empty((0, 3))


@njit(error_model="numpy")
def without_holes(parts: Runs, part: int, height: int, width: int) -> Levels:
    """(h, w) 1 in a part and in what is dark in it, but for holes so large that they may lie between
    fields."""
    runs, rows, numbers = parts
    mask, area = np.zeros((height, width), np.uint8), 0
    for y in range(height):
        for run in range(rows[y], rows[y + 1]):
            if numbers[run] == part:
                area += runs[run, 1] - runs[run, 0]
                mask[y, runs[run, 0] : runs[run, 1]] = 1
    holes = runs, rows, numbers = connected(mask, 0)
    are_kept = touching_border(holes, width) | (areas_of(holes) > MOST_HOLE * area)
    for y in range(height):
        for run in range(rows[y], rows[y + 1]):
            if not are_kept[numbers[run]]:
                mask[y, runs[run, 0] : runs[run, 1]] = 1
    return mask


@njit(error_model="numpy")
def halved(part: Levels) -> Levels:
    """(h // 2, w // 2) 1 where all of four pixels are."""
    half = np.empty((part.shape[0] // 2, part.shape[1] // 2), np.uint8)
    for y in range(half.shape[0]):
        one, other = part[2 * y], part[2 * y + 1]
        for x in range(half.shape[1]):
            half[y, x] = one[2 * x] & one[2 * x + 1] & other[2 * x] & other[2 * x + 1]
    return half


@njit(error_model="numpy")
def depths_in(part: Levels) -> Squares:
    """(h, w) squares of the distance from each pixel to the nearest one outside, of which there are none
    beyond the picture: along columns, then along rows (Saito and Toriwaki, Pattern Recognit. 27, 1994)."""
    height, width = part.shape
    depths = np.empty((height, width), np.uint16)
    away, line = np.full(width, FAR, np.uint16), np.full(width + 2 * FAR, FAR * FAR, np.uint16)
    for y in range(height):
        _step(away, part[y])
        depths[y] = away
    away[:] = FAR
    for y in range(height - 1, -1, -1):
        _step(away, part[y])
        reach = _take_squares(away, depths[y], line[FAR : FAR + width])
        for step in range(1, min(reach + 1, width)):
            _narrow(depths[y], line[FAR - step :], line[FAR + step :], np.uint16(step * step))
    return depths


@njit(error_model="numpy")
def _step(away: Squares, row: Levels) -> None:
    """Pixels from the row before to this one: one more to the nearest one outside, 0 where it is here."""
    wide_vectors()
    for x in range(len(row)):
        away[x] = min(np.uint16(away[x] + 1), np.uint16(FAR)) * np.uint16(row[x])


@njit(error_model="numpy")
def _take_squares(away: Squares, depths: Squares, line: Squares) -> int:
    """Of the smaller of two distances; the largest of these."""
    wide_vectors()
    most = np.uint16(0)
    for x in range(len(away)):
        nearest = min(away[x], depths[x])
        most = max(most, nearest)
        line[x] = depths[x] = np.uint16(nearest * nearest)
    return int(most)


@njit(error_model="numpy")
def _narrow(depths: Squares, left: Squares, right: Squares, square: np.uint16) -> None:
    wide_vectors()
    for x in range(len(depths)):
        depths[x] = min(depths[x], np.uint16(min(left[x], right[x]) + square))


@njit(error_model="numpy")
def _circles_in(depths: Squares, most: int, slack: float) -> Points:
    """(N, 3) as `inscribed`, so many at most."""
    circles, count = np.empty((most, 3)), 0
    while count < most and _finds_another(depths, circles, count, slack):
        count += 1
    return circles[:count]


@njit(error_model="numpy")
def _finds_another(depths: Squares, circles: Points, count: int, slack: float) -> bool:
    """Puts the largest circle that covers not much of the ones before after these, if there is one."""
    least = slack * LEAST_RADIUS * circles[0, 2] if count > 0 else 0.0
    most, found = np.uint16(least**2), False
    for y in range(depths.shape[0]):
        for x in range(depths.shape[1]):
            if depths[y, x] <= most:
                continue
            radius = np.sqrt(depths[y, x])
            if count == 0 or (_is_peak(depths, y, x) and _is_apart(circles[:count], x, y, radius, slack)):
                most, found = depths[y, x], True
                circles[count, 0], circles[count, 1], circles[count, 2] = x, y, radius
    return found


@njit(error_model="numpy")
def _is_peak(depths: Squares, y: int, x: int) -> bool:
    """None around it is deeper."""
    for row in range(max(y - 1, 0), min(y + 2, depths.shape[0])):
        for column in range(max(x - 1, 0), min(x + 2, depths.shape[1])):
            if depths[row, column] > depths[y, x]:
                return False
    return True


@njit(error_model="numpy")
def _is_apart(circles: Points, x: int, y: int, radius: float, slack: float) -> bool:
    for one in range(len(circles)):
        away = np.hypot(circles[one, 0] - x, circles[one, 1] - y)
        if away < slack * LEAST_AWAY * (radius + circles[one, 2]):
            return False
    return True


@njit(error_model="numpy")
def _rest(part: Levels, circles: Points) -> int:
    """Pixels of a part outside of all circles and more than one beside them."""
    rest = 0
    for y in range(part.shape[0]):
        for x in range(part.shape[1]):
            is_rest = part[y, x] > 0
            for one in range(len(circles)):
                is_rest &= np.hypot(circles[one, 0] - x, circles[one, 1] - y) > circles[one, 2] + 1
            rest += is_rest
    return rest
