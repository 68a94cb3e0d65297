"""The training loss and its adjoint for the raster, one pass over the picture."""

from __future__ import annotations

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.rasterize.binning import TILE
from renderer.rasterize.tiles import (
    BY_BLUE,
    BY_DEPTH,
    BY_GREEN,
    BY_RED,
    BY_WEIGHT,
    LEFT,
    PLANE_BLUE,
    PLANE_DEPTH,
    PLANE_GREEN,
    PLANE_RED,
    TOTAL,
)

# Columns of the sums that each picture row leaves.
COLOR_LOSS, DEPTH_LOSS, SQUARED_ERROR = range(3)
ZERO, ONE, HALF = np.float32(0.0), np.float32(1.0), np.float32(0.5)
BYTE = np.float32(1.0 / 255.0)


@njit(inline="always")
def _sign(value: np.float32) -> np.float32:
    return ONE if value > ZERO else (-ONE if value < ZERO else ZERO)


@njit(parallel=True, cache=True, error_model="numpy")
def masked_loss(
    planes: NDArray[np.float32],  # (5, H, W) blended picture, black background
    colors: NDArray[np.uint8],  # (H, W, 3)
    color_mask: NDArray[np.bool_],  # (H, W)
    depths: NDArray[np.float32],  # (H, W), 0 = not supervised
    tile_wanted: NDArray[np.bool_],
    color_weight: float,
    depth_weight: float,
    adjoint: NDArray[np.float32],  # (6, H, W), out on the wanted tiles
    sums: NDArray[np.float64],  # (H, 3), out: the unweighted sums of |colour|, |depth| and colour^2 errors
) -> None:
    """L1 of colour on tissue plus L1 of expected depth where it is measured and alpha > 0.5.

    Loss = color_weight * sum |color - photo| + depth_weight * sum |sum(w z) / sum(w) - depth|.
    """
    color_gradient, depth_gradient = np.float32(color_weight), np.float32(depth_weight)
    for y in prange(planes.shape[1]):
        sums[y] = 0.0
        for x in range(planes.shape[2]):
            if not tile_wanted[y // TILE, x // TILE]:
                continue
            for plane in range(adjoint.shape[0]):
                adjoint[plane, y, x] = ZERO
            if not color_mask[y, x]:
                continue
            red = planes[PLANE_RED, y, x] - np.float32(colors[y, x, 0]) * BYTE
            green = planes[PLANE_GREEN, y, x] - np.float32(colors[y, x, 1]) * BYTE
            blue = planes[PLANE_BLUE, y, x] - np.float32(colors[y, x, 2]) * BYTE
            sums[y, COLOR_LOSS] += abs(red) + abs(green) + abs(blue)
            sums[y, SQUARED_ERROR] += red * red + green * green + blue * blue
            by_red, by_green, by_blue = (
                color_gradient * _sign(red),
                color_gradient * _sign(green),
                color_gradient * _sign(blue),
            )
            adjoint[BY_RED, y, x], adjoint[BY_GREEN, y, x], adjoint[BY_BLUE, y, x] = by_red, by_green, by_blue
            # The depth terms of the total cancel: sum(w z) h - sum(w) D h = 0.
            adjoint[TOTAL, y, x] = (
                planes[PLANE_RED, y, x] * by_red
                + planes[PLANE_GREEN, y, x] * by_green
                + planes[PLANE_BLUE, y, x] * by_blue
            )
            weight = ONE - planes[LEFT, y, x]
            if depths[y, x] > ZERO and weight > HALF:
                expected = planes[PLANE_DEPTH, y, x] / weight
                error = expected - depths[y, x]
                sums[y, DEPTH_LOSS] += abs(error)
                by_depth = depth_gradient * _sign(error) / weight
                adjoint[BY_DEPTH, y, x] = by_depth
                adjoint[BY_WEIGHT, y, x] = -by_depth * expected
