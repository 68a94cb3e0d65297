"""The tones of a dark surround in a small copy of the picture."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enhance.field_outline import STEP
from enhance.field_regions import Levels

BRIGHTEST: Final = 64.0
"""Grey levels of V: a brighter corner is no surround."""
NOISIEST: Final = 12.0
"""Deviation of V in a corner, in grey levels: more is structure, not noise."""
DEVIATIONS, STRAY = 5.0, 0.2
"""Above the surround's V by STEP, so many deviations of its noise, and by this share of what
lies between it and the middle of the lit picture, it is field: stray light beside the rim is less."""
MOST_STRAY: Final = 0.5
"""Of the same: what is brighter is field, whatever the noise."""
LEAST_SHADED: Final = 0.1
"""Of the lit field: if it grows by so much with what is as dark as stray light, and ends sharply then, too,
this is tissue in the shade; stray light is a narrow band, or fades."""
LEVELS: Final = 256
Counts = NDArray[np.int32]


class Tones(NamedTuple):
    """V of the surround, in grey levels."""

    level: float
    """In the middle."""
    noise: float
    """Deviation."""
    least: float
    """Darker pixels are noise of the surround."""
    threshold: float
    """Darker pixels are surround, lit by stray light at most, or tissue in the shade."""
    most: float
    """No surround is brighter, however noisy."""
    may_be_shaded: bool
    """So many pixels lie between `least` and `threshold` that they may be tissue in the shade."""


@njit(error_model="numpy")
def tones_in(low: Levels) -> tuple[bool, Tones]:
    """Whether the darkest corner can be a surround, and its tones."""
    level, noise = _darkest_corner(low)
    if level > BRIGHTEST or noise > NOISIEST:
        return False, Tones(level, noise, 0.0, 0.0, 0.0, False)
    counts = counts_of(low)
    beyond = middle_above(counts, level + STEP) - level
    least = level + max(STEP, DEVIATIONS * noise)
    threshold = max(least, level + STRAY * beyond)
    most = max(threshold, level + MOST_STRAY * beyond)
    brighter, lit = counts[int(least) + 1 :].sum(), counts[int(threshold) + 1 :].sum()
    may_be_shaded = brighter >= (1 + LEAST_SHADED) * lit
    return True, Tones(level, noise, least, threshold, most, may_be_shaded)


@njit(error_model="numpy")
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
        middle = ranked(counts, count // 2)
        if middle < level or (middle == level and most < brightest):
            level, brightest = middle, most
            noise = 0.74 * (ranked(counts, 3 * count // 4) - ranked(counts, count // 4))
    return float(level), noise


@njit(error_model="numpy")
def counts_of(low: Levels) -> Counts:
    """(LEVELS,) pixels of each level."""
    # Four histograms in turn, as equal neighbours would wait for each other.
    parts = np.zeros((4, LEVELS), np.int32)
    for y in range(low.shape[0]):
        for x in range(low.shape[1]):
            parts[x & 3, low[y, x]] += 1
    counts = np.empty(LEVELS, np.int32)
    for level in range(LEVELS):
        counts[level] = parts[0, level] + parts[1, level] + parts[2, level] + parts[3, level]
    return counts


@njit(error_model="numpy")
def middle_above(counts: Counts, threshold: float) -> float:
    """The median of what is brighter; the threshold where nothing is."""
    first = int(np.floor(threshold)) + 1
    above = counts[first:]
    count = above.sum()
    if count == 0:
        return threshold
    return first + 0.5 * (ranked(above, (count - 1) // 2) + ranked(above, count // 2))


@njit(error_model="numpy")
def ranked(counts: NDArray[Any], place: int) -> int:
    """What stands at this place, from 0, of values of which there are so many each."""
    value, before = 0, int(counts[0])
    while before <= place:
        value += 1
        before += counts[value]
    return value
