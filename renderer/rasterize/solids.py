"""Splats as opaque bodies: each pixel shows the nearest alone. How a model is built, not how it looks."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.projection import (
    ACROSS,
    BLUE,
    CENTER_X,
    CENTER_Y,
    DEPTH,
    DOWN,
    LOG2_E,
    NEAR,
    RECORD_SIZE,
    RED,
    SHEAR,
    camera_vector,
    project,
)
from renderer.rasterize.rendered import Rendered
from renderer.splats import Float32Array, Shape, Splats

ELLIPSOID_REACH = 1.5
"""Standard deviations from the middle of a splat to its drawn edge."""
LEAST_OPACITY = 0.1
"""Of splats that are drawn as ellipsoids; fainter ones would hide what is seen."""
POINT_RADIUS = 1.25
"""Pixels."""
RIM = 0.55
"""How much darker an ellipsoid is at its edge, so that neighbours are told apart."""


def render_solids(splats: Splats, camera: Camera, shape: Shape, *, near: float = NEAR) -> Rendered:
    """Discs with a dark rim where the splats' ellipses are, or equal points; alpha is 0 or 1."""
    records, visible = np.zeros((len(splats), RECORD_SIZE), np.float32), np.zeros(len(splats), bool)
    colors = splats.seen_from(camera.position).colors
    values = (splats.means, splats.quats, splats.scales, splats.opacities, colors)
    project(*values, camera_vector(camera, near), False, records, visible)
    if shape == "ellipsoid":
        visible &= splats.opacities >= LEAST_OPACITY
    color = np.zeros((camera.height, camera.width, 3), np.float32)
    depth = np.zeros((camera.height, camera.width), np.float32)
    _paint(records[visible], shape == "point", color, depth)
    return Rendered(color, (depth > 0).astype(np.float32), depth)


@njit(cache=True)
def _paint(
    records: NDArray[np.float32],  # (N, RECORD_SIZE)
    as_points: bool,
    color: Float32Array,  # (H, W, 3), out
    depth: Float32Array,  # (H, W), out: 0 where nothing is
) -> None:
    """By a depth buffer; of equally near splats the first shows."""
    height, width = depth.shape
    for n in range(len(records)):
        record = records[n]
        x, y, z = np.float64(record[CENTER_X]), np.float64(record[CENTER_Y]), record[DEPTH]
        # Inverse of the covariance, of which the record holds -log2(e) / 2.
        a, shear, d = -2 * record[ACROSS] / LOG2_E, float(record[SHEAR]), -2 * record[DOWN] / LOG2_E
        if as_points:
            a, shear, d, reach = 1.0, 0.0, 1.0, POINT_RADIUS
        else:
            reach = ELLIPSOID_REACH
        if not (a > 0 and d > 0):
            continue
        half_width, half_height = reach * math.sqrt(1 / a + shear * shear / d), reach * math.sqrt(1 / d)
        if not (
            x + half_width > 0 and x - half_width < width and y + half_height > 0 and y - half_height < height
        ):
            continue
        first, last = max(0, int(y - half_height)), min(height - 1, int(y + half_height))
        left, right = max(0, int(x - half_width)), min(width - 1, int(x + half_width))
        for row in range(first, last + 1):
            dy = row + 0.5 - y
            for column in range(left, right + 1):
                u = column + 0.5 - x + shear * dy
                share = (a * u * u + d * dy * dy) / (reach * reach)
                if share <= 1 and (depth[row, column] == 0 or z < depth[row, column]):
                    depth[row, column] = z
                    light = np.float32(1.0 if as_points else 1 - RIM * share * share)
                    for channel in range(RED, BLUE + 1):
                        color[row, column, channel - RED] = light * record[channel]
