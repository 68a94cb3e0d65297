"""The convex hull of what is lit in a small copy of the picture, and the rows within.

What OpenCV has, too; but its calls, and numpy's between them, take longer than the work where a search is all
that is done with the picture.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from enhance.field_regions import Numbers

FINE = 16
"""Bits of a pixel's fraction."""


@njit(error_model="numpy")
def hull_of(ends: Numbers) -> Numbers:
    """(N, 2) corners, x and y, down the right side and up the left one, of the (2 n, 2) first and last pixels
    of rows from the top (Andrew, Inf. Process. Lett. 9(5), 1979)."""
    rows = len(ends) // 2
    corners, count = np.empty((2 * rows, 2), np.int32), 0
    for row in range(rows):
        count = _turned(corners, 0, count, ends[2 * row + 1])
    begin = count - 1 if (ends[-1] == ends[-2]).all() else count
    count = begin
    for row in range(rows - 1, -1, -1):
        count = _turned(corners, begin, count, ends[2 * row])
    if count > 1 and (corners[count - 1] == corners[0]).all():
        count -= 1
    return corners[:count]


@njit(error_model="numpy")
def _turned(corners: Numbers, begin: int, count: int, point: Numbers) -> int:
    """A point comes after those of this side, and those that it leaves within the hull go; how many there
    are."""
    while count - begin >= 2:
        last, before = corners[count - 1], corners[count - 2]
        turn = (last[0] - before[0]) * (point[1] - before[1]) - (last[1] - before[1]) * (point[0] - before[0])
        if turn > 0:
            break
        count -= 1
    corners[count, 0], corners[count, 1] = point[0], point[1]
    return count + 1


@njit(error_model="numpy")
def within(corners: Numbers, height: int, width: int) -> Numbers:
    """(h, 2) first column of each row within a convex outline, its sides included, and the one after the
    last; 0 and 0 where there is none."""
    spans = np.zeros((height, 2), np.int32)
    spans[:, 0] = width
    for corner in range(len(corners)):
        one, other = corners[corner - 1], corners[corner]
        _draw(spans, one, other)
        if len(corners) > 2:
            _fill(spans, one, other)
    for y in range(height):
        if spans[y, 0] >= spans[y, 1]:
            spans[y, 0] = spans[y, 1] = 0
    return spans


@njit(error_model="numpy")
def _draw(spans: Numbers, one: Numbers, other: Numbers) -> None:
    """A straight line from pixel to pixel; half way between two, that which is nearer to its left end."""
    left, right = (one, other) if one[0] <= other[0] else (other, one)
    across, down = right[0] - left[0], abs(right[1] - left[1])
    sign, steps = 1 if right[1] > left[1] else -1, max(across, down)
    for step in range(steps + 1):
        x, y = (0, 0) if steps == 0 else (_part(across, step, steps), _part(down, step, steps))
        _widen(spans, left[1] + sign * y, left[0] + x)


@njit(error_model="numpy")
def _part(whole: int, step: int, steps: int) -> int:
    """So many steps of a length, rounded; a half goes down."""
    return (2 * whole * step + steps - 1) // (2 * steps)


@njit(error_model="numpy")
def _fill(spans: Numbers, one: Numbers, other: Numbers) -> None:
    """What lies beside a side: where it crosses the rows, in steps of a fraction of a pixel."""
    top, bottom = (one, other) if one[1] <= other[1] else (other, one)
    rows = bottom[1] - top[1]
    for row in range(rows):
        slope = (((bottom[0] - top[0]) << (FINE + 1)) + rows) / (2 * rows)
        x = (top[0] << FINE) + row * int(slope)
        _widen(spans, top[1] + row, (x + (1 << (FINE - 1))) >> FINE)


@njit(error_model="numpy")
def _widen(spans: Numbers, y: int, x: int) -> None:
    spans[y, 0], spans[y, 1] = min(spans[y, 0], x), max(spans[y, 1], x + 1)
