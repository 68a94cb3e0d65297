"""Windows along a row of sums over their columns: by running sums, or added up where they are narrow."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from enhance.part import part
from enhance.wide_vectors import wide_vectors

NARROW: Final = 1
"""Pixels on each side, counted in full, of a window that is added up."""
EDGE: Final = NARROW + 1
"""Sums beyond each end of its row, which are 0."""


@part()
def accumulate(sums: NDArray[np.float64], whole: int, running: NDArray[np.float64]) -> None:
    """Running sums, 0 before the row and the total after it, so that no window needs a look at the border.

    Four at a time: each step waits for one addition instead of four.
    """
    wide_vectors()
    columns = len(sums)
    running[: whole + 2] = 0.0
    out = running[whole + 2 :]
    total = 0.0
    for step in range(columns // 4):
        x = np.uint64(4 * step)  # unsigned: no look at whether it counts from the end
        x1, x2, x3 = x + np.uint64(1), x + np.uint64(2), x + np.uint64(3)
        two = sums[x] + sums[x1]
        out[x] = total + sums[x]
        out[x1] = total + two
        out[x2] = total + (two + sums[x2])
        total += two + (sums[x2] + sums[x3])
        out[x3] = total
    for i in range(columns // 4 * 4, columns):
        total += sums[i]
        out[i] = total
    out[columns:] = total


@part(fastmath={"contract"})
def mean_of(
    running: NDArray[np.float64],
    whole: int,
    part: float,
    shares: NDArray[np.float64],
    tall: float,
    out: NDArray[np.float32],
) -> None:
    wide_vectors()
    inner, last, outer = running[1:], running[2 * whole + 2 :], running[2 * whole + 3 :]
    for x in range(len(out)):
        total = (1.0 - part) * (last[x] - inner[x]) + part * (outer[x] - running[x])
        out[x] = np.float32(total * (shares[x] * tall))


@part(forceinline=True, fastmath={"contract"})
def _variance(share: float, middle: float, square: float) -> np.float32:
    """Of a window with that mean, and that sum of squares over as much as one by `share`."""
    spread = np.float32(square * share - middle * middle)
    # Rounding can leave a flat window's variance slightly negative.
    return spread if spread > np.float32(0.0) else np.float32(0.0)


@part(fastmath={"contract"})
def describe(
    running_first: NDArray[np.float64],
    running_second: NDArray[np.float64],
    whole: int,
    part: float,
    shares: NDArray[np.float64],
    tall: float,
    variance: NDArray[np.float32],
    mean: NDArray[np.float32],
) -> None:
    """Of V in a row of windows."""
    wide_vectors()
    inner, last, outer = running_first[1:], running_first[2 * whole + 2 :], running_first[2 * whole + 3 :]
    inner_2, last_2 = running_second[1:], running_second[2 * whole + 2 :]
    outer_2 = running_second[2 * whole + 3 :]
    for x in range(len(mean)):
        share = shares[x] * tall
        middle = share * ((1.0 - part) * (last[x] - inner[x]) + part * (outer[x] - running_first[x]))
        square = (1.0 - part) * (last_2[x] - inner_2[x]) + part * (outer_2[x] - running_second[x])
        variance[x] = _variance(share, middle, square)
        mean[x] = np.float32(middle)


@part(fastmath={"contract"})
def mean_narrow(
    sums: NDArray[np.float64],  # (columns + 2 EDGE,)
    part: float,
    shares: NDArray[np.float64],
    tall: float,
    out: NDArray[np.float32],
) -> None:
    """As `mean_of`, of a window with NARROW whole pixels on each side."""
    wide_vectors()
    left, near, middle, far, right = sums, sums[1:], sums[2:], sums[3:], sums[4:]
    for x in range(len(out)):
        total = (near[x] + middle[x] + far[x]) + part * (left[x] + right[x])
        out[x] = np.float32(total * (shares[x] * tall))


@part(fastmath={"contract"})
def describe_narrow(
    first: NDArray[np.float64],  # (columns + 2 EDGE,)
    second: NDArray[np.float64],
    part: float,
    shares: NDArray[np.float64],
    tall: float,
    variance: NDArray[np.float32],
    mean: NDArray[np.float32],
) -> None:
    """As `describe`, of a window with NARROW whole pixels on each side."""
    wide_vectors()
    left, near, here, far, right = first, first[1:], first[2:], first[3:], first[4:]
    left_2, near_2, here_2, far_2, right_2 = second, second[1:], second[2:], second[3:], second[4:]
    for x in range(len(mean)):
        share = shares[x] * tall
        middle = share * ((near[x] + here[x] + far[x]) + part * (left[x] + right[x]))
        square = (near_2[x] + here_2[x] + far_2[x]) + part * (left_2[x] + right_2[x])
        variance[x] = _variance(share, middle, square)
        mean[x] = np.float32(middle)
