"""A mesh as a camera sees it: the nearest triangle behind each pixel, shaded as by a light at the lens."""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.rasterize.rendered import Rendered
from renderer.surface.mesh import Mesh

BAND: Final = 16
"""Rows that one thread fills."""
AMBIENT: Final = 0.35
"""Share of a colour that does not depend on where the surface faces."""


def render_mesh(mesh: Mesh, camera: Camera, near: float) -> Rendered:
    """Opaque, both sides alike; triangles that reach to z <= near are left out."""
    image = np.zeros((camera.height, camera.width, 3), np.float32)
    depth = np.zeros((camera.height, camera.width), np.float32)
    pixels, depths = camera.project(mesh.vertices.astype(np.float64))
    facing = mesh.facing(camera.position)[:, None]
    shaded = (mesh.colors * (AMBIENT + (1 - AMBIENT) * facing)).astype(np.float32)
    kept = mesh.faces[(depths[mesh.faces] > near).all(axis=1)]
    _fill(np.ascontiguousarray(kept), pixels, depths, shaded, image, depth)
    return Rendered(image, (depth > 0).astype(np.float32), depth)


@njit(parallel=True, cache=True)
def _fill(
    faces: NDArray[np.int32],  # (F, 3)
    pixels: NDArray[np.float64],  # (V, 2)
    depths: NDArray[np.float64],  # (V,)
    colors: NDArray[np.float32],  # (V, 3)
    image: NDArray[np.float32],  # (H, W, 3), out
    depth: NDArray[np.float32],  # (H, W), 0 = nothing yet
) -> None:
    height, width = depth.shape
    for band in prange((height + BAND - 1) // BAND):
        first, last = band * BAND, min((band + 1) * BAND, height)
        for n in range(len(faces)):
            a, b, c = faces[n, 0], faces[n, 1], faces[n, 2]
            ax, ay = pixels[a, 0], pixels[a, 1]
            bx, by = pixels[b, 0], pixels[b, 1]
            cx, cy = pixels[c, 0], pixels[c, 1]
            top = max(int(np.ceil(max(min(ay, by, cy), -1.0) - 0.5)), first)
            bottom = min(int(np.floor(min(max(ay, by, cy), height + 1.0) - 0.5)) + 1, last)
            if top >= bottom:
                continue
            left = max(int(np.ceil(max(min(ax, bx, cx), -1.0) - 0.5)), 0)
            right = min(int(np.floor(min(max(ax, bx, cx), width + 1.0) - 0.5)) + 1, width)
            area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
            if area == 0.0:
                continue
            for row in range(top, bottom):
                y = row + 0.5
                for column in range(left, right):
                    x = column + 0.5
                    u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
                    v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
                    w = 1.0 - u - v
                    if u < 0.0 or v < 0.0 or w < 0.0:
                        continue
                    # What goes evenly over the triangle goes evenly over the picture when divided by depth.
                    u, v, w = u / depths[a], v / depths[b], w / depths[c]
                    z = 1.0 / (u + v + w)
                    if depth[row, column] > 0 and depth[row, column] <= z:
                        continue
                    depth[row, column] = z
                    for k in range(3):
                        image[row, column, k] = z * (u * colors[a, k] + v * colors[b, k] + w * colors[c, k])
