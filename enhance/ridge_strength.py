"""How strong dark lines are at one scale, fused: six derivatives of a Gaussian, folded, and what follows from
them, while a few rows are in the cache."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.image import Float32Image
from enhance.wide_vectors import wide_vectors

STRIP: Final = 32
"""Rows of one task."""
WIDTH: Final = 256
"""Columns that are worked on at once."""
Planes = NDArray[np.float64]


@njit(parallel=True, nogil=True, cache=True, fastmath={"contract"}, error_model="numpy")
def strengthen(
    padded: Float32Image,  # (H + 2 margin, W + 2 margin), green with its border reflected
    margin: int,  # at least the kernels' reach
    halves: Planes,  # (3, even reach + 1): the middle and what follows of the kernels of order 0, 1 and 2
    sigma: float,  # pixels
    floor: float,  # added to the blurred green
    out: Float32Image,  # (H, W), in and out: the larger of what it holds and the ridges of this scale
) -> None:
    """See `enhance.ridges.vesselness`; `enhance.reference.ridge` is the same, step by step."""
    rows, columns = out.shape
    reach = halves.shape[1] - 1
    for strip in prange((rows + STRIP - 1) // STRIP):
        down = np.empty((3, WIDTH + 2 * reach))
        both = np.empty((6, WIDTH))
        for x0 in range(0, columns, WIDTH):
            count = min(WIDTH, columns - x0)
            for y in range(strip * STRIP, min((strip + 1) * STRIP, rows)):
                _fold_down(padded, y + margin, x0 + margin - reach, count + 2 * reach, halves, down)
                _fold_across(down, count, halves, both)
                _keep_larger(both, sigma, floor, out[y, x0 : x0 + count])


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _fold_down(padded: Float32Image, y: int, x: int, count: int, halves: Planes, down: Planes) -> None:
    """From column x on, row y of the derivatives of order 0, 1 and 2 along y."""
    wide_vectors()
    middle = padded[y, x:]
    zeroth, second = halves[0, 0], halves[2, 0]
    for i in range(count):
        value = np.float64(middle[i])
        down[0, i], down[1, i], down[2, i] = zeroth * value, 0.0, second * value
    for k in range(1, halves.shape[1], 2):
        # Two rows on either side at once, as sums are read and written once for both.
        above, below, higher, lower = padded[y - k], padded[y + k], padded[y - k - 1], padded[y + k + 1]
        a0, a1, a2 = halves[0, k], halves[1, k], halves[2, k]
        b0, b1, b2 = halves[0, k + 1], halves[1, k + 1], halves[2, k + 1]
        for i in range(count):
            up, low = np.float64(above[x + i]), np.float64(below[x + i])
            far_up, far_low = np.float64(higher[x + i]), np.float64(lower[x + i])
            near, far = up + low, far_up + far_low
            down[0, i] += a0 * near + b0 * far
            down[1, i] += a1 * (low - up) + b1 * (far_low - far_up)
            down[2, i] += a2 * near + b2 * far


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _fold_across(down: Planes, count: int, halves: Planes, both: Planes) -> None:
    """The blurred green and its derivatives along x, y, xx, xy, yy."""
    wide_vectors()
    reach = halves.shape[1] - 1
    zeroth, second = halves[0, 0], halves[2, 0]
    for i in range(count):
        smooth, slope, bend = down[0, reach + i], down[1, reach + i], down[2, reach + i]
        both[0, i], both[1, i], both[2, i] = zeroth * smooth, 0.0, zeroth * slope
        both[3, i], both[4, i], both[5, i] = second * smooth, 0.0, zeroth * bend
    for k in range(1, reach + 1, 2):
        a0, a1, a2 = halves[0, k], halves[1, k], halves[2, k]
        b0, b1, b2 = halves[0, k + 1], halves[1, k + 1], halves[2, k + 1]
        left, right = down[:, reach - k :], down[:, reach + k :]
        far_left, far_right = down[:, reach - k - 1 :], down[:, reach + k + 1 :]
        for i in range(count):
            near, far = left[0, i] + right[0, i], far_left[0, i] + far_right[0, i]
            both[0, i] += a0 * near + b0 * far
            both[1, i] += a1 * (right[0, i] - left[0, i]) + b1 * (far_right[0, i] - far_left[0, i])
            both[3, i] += a2 * near + b2 * far
            near, far = left[1, i] + right[1, i], far_left[1, i] + far_right[1, i]
            both[2, i] += a0 * near + b0 * far
            both[4, i] += a1 * (right[1, i] - left[1, i]) + b1 * (far_right[1, i] - far_left[1, i])
            near, far = left[2, i] + right[2, i], far_left[2, i] + far_right[2, i]
            both[5, i] += a0 * near + b0 * far


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _keep_larger(both: Planes, sigma: float, floor: float, out: Float32Image) -> None:
    wide_vectors()
    for i in range(len(out)):
        middle, half, cross = (both[3, i] + both[5, i]) / 2, (both[3, i] - both[5, i]) / 2, both[4, i]
        apart = math.sqrt(half * half + cross * cross)
        slope = math.sqrt(both[1, i] * both[1, i] + both[2, i] * both[2, i])
        line = sigma * sigma * (middle + apart - abs(middle - apart)) - sigma * slope
        level = both[0, i] + floor
        relative = np.float32(line / level) if level > 0 else np.float32(0)
        out[i] = relative if relative > out[i] else out[i]
