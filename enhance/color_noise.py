"""Coarse noise of colour, blotches of some 3 to 10 pixels: how much of it an image has."""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enhance.part import part

PLACES: Final = 512
"""Evenly spread ones at least that tell, where there are so many."""
SIDE: Final = 4
"""Pixels of the blocks whose means are compared: noise that is finer hardly shows in them."""
WHOLE: Final = 3 * SIDE
"""Pixels of a place: three blocks across and three down, which share the middle one."""
DARK, CLIPPED = 24 / 255, 250 / 255
"""Of full scale: below or above, noise is cut off."""
VISIBLE, LARGE = 1.5, 96.0
"""Grey levels: smaller second differences tell nothing, as rounding makes them, too; larger ones are edges of
things that have a colour, as in a chart."""
ENOUGH: Final = 128
"""Second differences: fewer say less by as much, so that no tiny image or mask has noise by chance."""
FEW, MANY = 0.2, 0.4
"""Share of opposite differences up to which none is smoothed away, and from which on all is: tissue has up to
.09, after strong compression up to .11; blotches of 3 grey levels that one can see have .17 to .38, of 12
after strong compression .29 to .45. Where there are fewer, thin vessels lose more than freckles do (on the
training half of `visibility_front` and copies made worse)."""


class Opposites(NamedTuple):
    """Counts, each for as many pixels as there are of it."""

    opposite: float
    """Where red curves up and green down, or the other way round: structures move both alike, noise of colour
    moves them against each other."""
    all: float

    @property
    def share(self) -> float | None:
        """None: nothing tells."""
        return self.opposite / self.all if self.all > 0 else None


NO_OPPOSITES: Final = Opposites(0.0, 0.0)


def opposites(
    pixels: NDArray[Any], keep: NDArray[np.uint8], spans: NDArray[np.int32], full: int
) -> Opposites:
    """Of an image as `Shown` has it."""
    step = max(WHOLE, math.isqrt(pixels.shape[0] * pixels.shape[1] // PLACES))
    unit = full / 255
    opposite, total = _count(
        pixels,
        keep,
        spans,
        step,
        DARK * full,
        CLIPPED * full,
        VISIBLE * unit,
        LARGE * unit,
        0 if full > 1 else 0.0,
    )
    total = max(total, ENOUGH) if total > 0 else 0
    return Opposites(float(opposite * step * step), float(total * step * step))


def coarse_share(noise: float | None) -> float:
    """Of the noise of colour that is to be smoothed away, in [0, 1], by the share of opposite differences."""
    return 0.0 if noise is None else min(max((noise - FEW) / (MANY - FEW), 0.0), 1.0)


@njit(cache=True, error_model="numpy")
def _count(
    pixels: NDArray[Any],  # (H, W, 3)
    keep: NDArray[np.uint8],  # (H, W) 0 or 1, or empty: all
    spans: NDArray[np.int32],  # (H, 2) of `FieldOfView.spans`, or empty: all
    step: int,
    dark: float,
    clipped: float,
    least: float,
    largest: float,
    zero: int | float,  # of the type that sums of pixels have: of whole numbers, they take half the time
) -> tuple[int, int]:
    """Second differences of red and green, along rows and columns, that are opposite; and all."""
    opposite, total = 0, 0
    for y in range(0, pixels.shape[0] - WHOLE + 1, step):
        for x in range(0, pixels.shape[1] - WHOLE + 1, step):
            counts = len(keep) == 0 or keep[y + WHOLE // 2, x + WHOLE // 2] > 0
            for end in (y, y + WHOLE - 1):
                if len(spans) > 0:
                    counts = counts and spans[end, 0] <= x and x + WHOLE <= spans[end, 1]
            if not counts:
                continue
            red, green = _mean(pixels, y + SIDE, x + SIDE, zero)
            for down in range(2):
                v, u = (0, SIDE) if down else (SIDE, 0)
                red_before, green_before = _mean(pixels, y + v, x + u, zero)
                red_after, green_after = _mean(pixels, y + 2 * SIDE - v, x + 2 * SIDE - u, zero)
                brightest = max(red, red_before, red_after, green, green_before, green_after)
                if max(red, green) < dark or brightest >= clipped:
                    continue
                total += 1
                red_bend = red_before + red_after - 2 * red
                green_bend = green_before + green_after - 2 * green
                smaller, larger = min(abs(red_bend), abs(green_bend)), max(abs(red_bend), abs(green_bend))
                if red_bend * green_bend < 0 and smaller > least and larger < largest:
                    opposite += 1
    return opposite, total


@part()
def _mean(pixels: NDArray[Any], y: int, x: int, zero: int | float) -> tuple[float, float]:
    """Red and green of a block."""
    red, green = zero, zero
    for v in range(y, y + SIDE):
        row = pixels[np.uint64(v)]
        for u in range(np.uint64(x), np.uint64(x + SIDE)):
            red += row[u, 0]
            green += row[u, 1]
    return red / (SIDE * SIDE), green / (SIDE * SIDE)
