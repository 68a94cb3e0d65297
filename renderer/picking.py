"""The surface point behind a pixel: where the expected depth says it is. Of a model, not measured tissue."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.paint import painted
from renderer.rasterize.binning import TILE
from renderer.rasterize.cpu import BLACK, Rasterizer
from renderer.splats import RenderMode, Splats

SOLID = 0.5
"""Alpha above which expected depth is taken for a surface, as in training."""


@dataclass(frozen=True, eq=False)
class SurfacePoint:
    """Where a pixel sees the surface."""

    point: FloatArray
    """(3,) in the world."""
    ray: FloatArray
    """(3,) how the point moves as its depth grows by one scene unit."""
    spread: float
    """Standard deviation of the depths that are blended there, in scene units along z."""

    @classmethod
    def at(cls, camera: Camera, pixel: tuple[int, int], depth: float, spread: float = 0.0) -> SurfacePoint:
        """On the ray through the middle of pixel (column, row)."""
        column, row = pixel
        pose = camera.world_from_camera
        x, y = (column + 0.5 - camera.cx) / camera.fx, (row + 0.5 - camera.cy) / camera.fy
        ray = pose[:3, :3] @ [x, y, 1.0]
        return cls(np.asarray(ray * depth + pose[:3, 3]), np.asarray(ray), spread)


def surface_point(
    splats: Splats, camera: Camera, pixel: tuple[int, int], near: float, mode: RenderMode = "default"
) -> SurfacePoint | None:
    """On the ray through the middle of pixel (column, row), at expected depth.

    None where there is no surface: outside the picture, or alpha <= 0.5. Only the pixel's tile is blended,
    to the very numbers of the whole picture.
    """
    column, row = pixel
    if not (0 <= column < camera.width and 0 <= row < camera.height):
        return None
    from_camera = camera.camera_from_world
    depths = splats.means @ from_camera[2, :3] + from_camera[2, 3]
    farthest = max(float(np.abs(depths).max(initial=0.0)), 1e-30)
    # Blended as colours, so that mean and variance have the same weights: depths and their squares.
    shares = depths / farthest
    shown = painted(splats, np.stack((shares, shares**2, np.zeros_like(shares)), axis=1))
    rasterizer = Rasterizer(camera.width, camera.height)
    wanted = np.zeros((rasterizer.rows, rasterizer.columns), bool)
    wanted[row // TILE, column // TILE] = True
    rasterizer.forward(shown, camera, near, wanted, mode)
    rendered = rasterizer.rendered(camera.width, camera.height, BLACK)
    alpha = float(rendered.alpha[row, column])
    if alpha <= SOLID:
        return None
    depth = float(rendered.depth[row, column])
    mean, square = (float(rendered.image[row, column, channel]) / alpha for channel in (0, 1))
    spread = farthest * float(np.sqrt(max(square - mean**2, 0.0)))
    return SurfacePoint.at(camera, pixel, depth, spread)
