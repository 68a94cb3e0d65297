"""Where a surface faces, from its depth: of a plane, 1 / z is linear in the pixel, so what is fitted to it
around each pixel gives the plane there."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.splats import Float32Array

SHARE: Final = 1 / 80
"""Standard deviation of the weights around a pixel, of the width of the image: of those tried, from 1/640 to
1/60, the nearest to the true normals of the phantom (0.8 degrees, median 0.5; 1/320: 2.5 and 1.7)."""
LEAST: Final = 1.0
"""px; the same at least."""
REACH: Final = 3
"""Standard deviations to which they go."""
NARROW: Final = 0.05
"""Of the spread that all pixels around have, what those that are seen need: of a line of pixels, no plane
follows."""


def surface_normals(depth: Float32Array, camera: Camera) -> Float32Array:
    """(H, W, 3) unit normals that face the camera, in its axes (x right, y down, z forward), of expected
    depth (H, W) in scene units; 0 where there is no depth, or too little around to tell."""
    seen = depth > 0
    inverse = np.divide(1, depth, out=np.zeros_like(depth), where=seen)
    slope_x, slope_y, known = _slopes(inverse, seen)
    rows, columns = np.indices(depth.shape, dtype=np.float32)
    x, y = (columns + 0.5 - camera.cx) / camera.fx, (rows + 0.5 - camera.cy) / camera.fy
    # With x = X / z and y = Y / z, the plane n . (X, Y, z) = d is 1 / z = (n_x x + n_y y + n_z) / d.
    across, down = slope_x * np.float32(camera.fx), slope_y * np.float32(camera.fy)
    normals = np.stack([-across, -down, across * x + down * y - inverse], axis=2)
    length = np.linalg.norm(normals, axis=2, keepdims=True)
    told = (known & seen)[..., None] & (length > 0)
    unit: Float32Array = np.divide(normals, length, out=np.zeros_like(normals), where=told).astype(np.float32)
    return unit


def _slopes(
    values: Float32Array, seen: NDArray[np.bool_]
) -> tuple[Float32Array, Float32Array, NDArray[np.bool_]]:
    """Per pixel across and down, of the plane through the values that are seen around each, by weighted least
    squares; and where there is one."""
    deviation = max(SHARE * values.shape[1], LEAST)
    at = np.arange(-round(REACH * deviation), round(REACH * deviation) + 1)
    weight = np.exp(-0.5 * (at / deviation) ** 2)
    moments = weight / weight.sum(), at * weight / weight.sum(), at**2 * weight / weight.sum()

    def over(image: Float32Array, across: int, down: int) -> Float32Array:
        """Sums of the image times powers of the way from each pixel."""
        summed = cv2.sepFilter2D(image, -1, moments[across], moments[down], borderType=cv2.BORDER_CONSTANT)
        return np.asarray(summed, np.float32)

    counts = seen.astype(np.float32)
    total = over(counts, 0, 0)
    share = np.divide(1, total, out=np.zeros_like(total), where=total > 0)
    x, y = over(counts, 1, 0) * share, over(counts, 0, 1) * share
    xx, yy = over(counts, 2, 0) * share - x * x, over(counts, 0, 2) * share - y * y
    xy = over(counts, 1, 1) * share - x * y
    mean = over(values, 0, 0) * share
    with_x, with_y = over(values, 1, 0) * share - x * mean, over(values, 0, 1) * share - y * mean
    spread = xx * yy - xy * xy
    known = spread > (NARROW * deviation**2) ** 2
    safe = np.where(known, spread, 1)
    return (yy * with_x - xy * with_y) / safe, (xx * with_y - xy * with_x) / safe, known
