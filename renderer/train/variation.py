"""Total variation of the rendered picture and of its inverse depth: what fills places that no frame shows."""

from __future__ import annotations

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.rasterize.tiles import LEFT, PLANE_DEPTH, PLANE_RED

ZERO, ONE, HALF = np.float32(0.0), np.float32(1.0), np.float32(0.5)


def add_variation(
    planes: NDArray[np.float32], color_weight: float, inverse_weight: float, extra: NDArray[np.float32]
) -> float:
    """The weighted sum of both, anisotropic; its gradient is added to `extra`.

    Each is the sum over neighbours to the right and below of |difference|, per number: colours over the
    whole picture, 1 / depth between pixels of alpha > 0.5 (Wang et al., EndoGaussian).

    Args:
        planes: (5, H, W) blended picture without padding.
        color_weight, inverse_weight: the second in units of depth.
        extra: (4, H, W) gradient by red, green, blue and expected depth, added to.
    """
    height, width = planes.shape[1:]
    sums = np.empty((height, 2))
    per_color, per_pixel = color_weight / (3 * height * width), inverse_weight / (height * width)
    inverse = np.empty((height, width), np.float32)
    _invert(planes, inverse)
    _add(planes, inverse, np.float32(per_color), np.float32(per_pixel), extra, sums)
    color, nearness = sums.sum(axis=0)
    return float(per_color * color + per_pixel * nearness)


@njit(parallel=True, cache=True, error_model="numpy")
def _invert(planes: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    """1 / expected depth; 0 where too little is drawn."""
    for y in prange(out.shape[0]):
        for x in range(out.shape[1]):
            weight, depth = ONE - planes[LEFT, y, x], planes[PLANE_DEPTH, y, x]
            out[y, x] = weight / depth if weight > HALF and depth > ZERO else ZERO


@njit(forceinline=True, error_model="numpy")
def _sign(value: np.float32) -> np.float32:
    return ONE if value > ZERO else (-ONE if value < ZERO else ZERO)


@njit(forceinline=True, error_model="numpy")
def _apart(near: np.float32, other: np.float32) -> np.float32:
    """Their difference, if both are drawn."""
    return near - other if other > ZERO else ZERO


@njit(parallel=True, cache=True, error_model="numpy")
def _add(
    planes: NDArray[np.float32],
    inverse: NDArray[np.float32],
    color_weight: np.float32,
    inverse_weight: np.float32,
    extra: NDArray[np.float32],
    sums: NDArray[np.float64],  # (H, 2), out
) -> None:
    height, width = inverse.shape
    for y in prange(height):
        above, below = max(y - 1, 0), min(y + 1, height - 1)
        color_sum = nearness_sum = 0.0
        for x in range(width):
            left, right = max(x - 1, 0), min(x + 1, width - 1)
            for c in range(3):
                picture = planes[PLANE_RED + c]
                here = picture[y, x]
                color_sum += abs(here - picture[y, right]) + abs(here - picture[below, x])
                slope = _sign(here - picture[y, left]) + _sign(here - picture[y, right])
                slope += _sign(here - picture[above, x]) + _sign(here - picture[below, x])
                extra[c, y, x] += color_weight * slope
            near = inverse[y, x]
            if near == ZERO:
                continue
            right_part = _apart(near, inverse[y, right])
            below_part = _apart(near, inverse[below, x])
            nearness_sum += np.float64(abs(right_part)) + np.float64(abs(below_part))
            slope = _sign(right_part) + _sign(below_part)
            slope += _sign(_apart(near, inverse[y, left])) + _sign(_apart(near, inverse[above, x]))
            extra[3, y, x] -= inverse_weight * slope * near * near
        sums[y, 0], sums[y, 1] = color_sum, nearness_sum
