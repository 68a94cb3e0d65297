"""A signed distance to the surface from the depth maps of many cameras (Curless and Levoy, SIGGRAPH 1996)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.camera import FloatArray
from renderer.splats import Float32Array
from renderer.surface.maps import Maps

MOST_VOXELS: Final = 24_000_000
TRUNCATED: Final = 4.0
"""Voxels before and behind the surface in which distances are averaged; behind, nothing is known."""


@dataclass(frozen=True, eq=False)
class Volume:
    """Distances at the corners of a grid."""

    origin: FloatArray
    """(3,) of the first corner, in the world."""
    voxel: float
    """Length of an edge in scene units."""
    distances: Float32Array
    """(X, Y, Z) in voxels, positive before the surface; between -1 and 1 times TRUNCATED."""
    weights: Float32Array
    """(X, Y, Z) how many cameras have seen it; 0 = nothing is known."""


def fused(views: Sequence[Maps], voxel: float) -> Volume:
    """Of the part of the world that the views see; with larger voxels where that would need too many."""
    points = np.concatenate([view.camera.unproject(view.depth)[view.seen] for view in views])
    if not len(points):
        return Volume(np.zeros(3), voxel, np.ones((1, 1, 1), np.float32), np.zeros((1, 1, 1), np.float32))
    # Stray Gaussians far away would only make the box large.
    low, high = np.percentile(points, (0.1, 99.9), axis=0)
    margin = 2 * TRUNCATED * voxel
    extent = high - low + 2 * margin
    voxel = max(voxel, float(np.cbrt(np.prod(extent) / MOST_VOXELS)))
    counts = np.ceil(extent / voxel).astype(int) + 1
    distances, weights = np.zeros(tuple(counts), np.float32), np.zeros(tuple(counts), np.float32)
    for view in views:
        camera = view.camera
        lens = np.array(camera.lens)
        depth = np.where(view.seen, view.depth, np.float32(0))
        _add(depth, lens, camera.camera_from_world, low - margin, voxel, distances, weights)
    np.divide(distances, weights, out=distances, where=weights > 0)
    return Volume(low - margin, voxel, distances, weights)


@njit(parallel=True, cache=True)
def _add(
    depth: NDArray[np.float32],  # (H, W), 0 = nothing seen
    lens: NDArray[np.float64],  # fx fy cx cy
    pose: NDArray[np.float64],  # camera from world
    origin: NDArray[np.float64],
    voxel: float,
    distances: NDArray[np.float32],  # (X, Y, Z), sums
    weights: NDArray[np.float32],
) -> None:
    height, width = depth.shape
    for i in prange(distances.shape[0]):
        for j in range(distances.shape[1]):
            for k in range(distances.shape[2]):
                x = origin[0] + voxel * i
                y = origin[1] + voxel * j
                z = origin[2] + voxel * k
                away = pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z + pose[2, 3]
                if away <= 0:
                    continue
                across = pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z + pose[0, 3]
                down = pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z + pose[1, 3]
                column = int(np.floor(lens[0] * across / away + lens[2]))
                row = int(np.floor(lens[1] * down / away + lens[3]))
                if column < 0 or row < 0 or column >= width or row >= height:
                    continue
                found = depth[row, column]
                if found <= 0:
                    continue
                distance = (found - away) / voxel
                if distance < -TRUNCATED:
                    continue
                distances[i, j, k] += np.float32(min(distance, TRUNCATED))
                weights[i, j, k] += np.float32(1)
