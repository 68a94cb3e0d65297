"""From blended planes to a picture, and from gradients by a picture to the adjoint of the planes.

One pass over memory each; padding to whole tiles is left out of pictures, and 0 in adjoints.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

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

Plane = NDArray[np.float32]
ZERO, ONE = np.float32(0.0), np.float32(1.0)


@njit(parallel=True, cache=True, error_model="numpy")
def compose(
    planes: Plane,  # (5, H', W')
    background: Plane,  # (3,)
    image: Plane,  # (H, W, 3), out
    alpha: Plane,  # (H, W), out
    depth: Plane,  # (H, W), out: expected, 0 where nothing is
) -> None:
    for y in prange(len(alpha)):
        for x in range(alpha.shape[1]):
            left = planes[LEFT, y, x]
            seen = ONE - left
            image[y, x, 0] = planes[PLANE_RED, y, x] + left * background[0]
            image[y, x, 1] = planes[PLANE_GREEN, y, x] + left * background[1]
            image[y, x, 2] = planes[PLANE_BLUE, y, x] + left * background[2]
            alpha[y, x] = seen
            depth[y, x] = planes[PLANE_DEPTH, y, x] / seen if seen > ZERO else ZERO


@njit(parallel=True, cache=True, error_model="numpy")
def adjoint_of(
    planes: Plane,  # (5, H', W')
    background: Plane,  # (3,)
    by_image: Plane,  # (H, W, 3)
    by_alpha: Plane,  # (H, W)
    by_depth: Plane,  # (H, W), by the expected depth
    adjoint: Plane,  # (6, H', W'), out
) -> None:
    height, width = by_alpha.shape
    for y in prange(adjoint.shape[1]):
        if y >= height:
            adjoint[:, y] = ZERO
            continue
        for x in range(width):
            seen = ONE - planes[LEFT, y, x]
            red, green, blue = by_image[y, x, 0], by_image[y, x, 1], by_image[y, x, 2]
            far = by_depth[y, x] / seen if seen > ZERO else ZERO
            expected = planes[PLANE_DEPTH, y, x] / seen if seen > ZERO else ZERO
            behind = red * background[0] + green * background[1] + blue * background[2]
            weight = by_alpha[y, x] - behind - far * expected
            adjoint[BY_RED, y, x], adjoint[BY_GREEN, y, x], adjoint[BY_BLUE, y, x] = red, green, blue
            adjoint[BY_DEPTH, y, x], adjoint[BY_WEIGHT, y, x] = far, weight
            # The depth terms of the total cancel: sum(w z) h - sum(w) D h = 0.
            adjoint[TOTAL, y, x] = (
                planes[PLANE_RED, y, x] * red
                + planes[PLANE_GREEN, y, x] * green
                + planes[PLANE_BLUE, y, x] * blue
                + seen * (by_alpha[y, x] - behind)
            )
        adjoint[:, y, width:] = ZERO
