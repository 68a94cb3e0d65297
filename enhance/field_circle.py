"""The circle through most of the points of a rim."""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enhance.field import MOST_CORNERS
from enhance.image import BoolImage

LEAST_FREE: Final = MOST_CORNERS // 6
"""Points, at least, that tell a circle."""
CIRCLE_TOLERANCE: Final = 1.5
"""Pixels, or so many thousandths of the radius where that is more, that a point may lie off a circle."""

Points = NDArray[np.float64]
Fit = tuple[int, tuple[float, float], tuple[float, float, float], float]
"""Points that are not cropped, the middle of all, and `circle_through` those, to hundredths of a pixel, if
there are enough."""


@njit(cache=True, error_model="numpy")
def fit_of(points: Points, cropped: BoolImage) -> Fit:
    free = points[~cropped]
    x, y = points[:, 0], points[:, 1]
    middle = (x.max() + x.min()) / 2, (y.max() + y.min()) / 2
    if len(free) < LEAST_FREE:
        return len(free), middle, (0.0, 0.0, 0.0), 0.0
    across, down, radius, share = circle_through(free)
    return len(free), middle, (_rounded(across), _rounded(down), _rounded(radius)), share


@njit(error_model="numpy")
def _rounded(value: float) -> float:
    """To hundredths; Python's own `round` takes longer than a kernel."""
    return float(np.rint(value * 100) / 100)


@njit(error_model="numpy")
def circle_through(points: Points) -> tuple[float, float, float, float]:
    """Middle, x and y, and radius through most of the points (Kasa, IEEE Trans. Instrum. Meas. 25, 1976; the
    worst are left out again and again), and the share of points on it."""
    apart, most = np.zeros(len(points)), 0.0
    x, y, radius, tolerance = 0.0, 0.0, 0.0, 0.0
    for _ in range(6):
        before = x, y, radius
        x, y, radius = _kasa(points, apart, most)
        if (x, y, radius) == before:
            break
        for i in range(len(points)):
            apart[i] = abs(np.sqrt((points[i, 0] - x) ** 2 + (points[i, 1] - y) ** 2) - radius)
        tolerance = tolerance_of(radius)
        most = max(tolerance, 2 * median(apart))
    near = 0
    for i in range(len(points)):
        near += apart[i] <= tolerance
    return x, y, radius, near / len(points)


@njit(error_model="numpy")
def median(values: Points) -> float:
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


@njit(error_model="numpy")
def tolerance_of(radius: float) -> float:
    return float(max(CIRCLE_TOLERANCE, CIRCLE_TOLERANCE * radius / 1000))
