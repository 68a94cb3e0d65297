"""The surface point behind a pixel: where the expected depth says it is. Of a model, not measured tissue."""

from __future__ import annotations

import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.rasterize.binning import TILE
from renderer.rasterize.cpu import BLACK, Rasterizer
from renderer.splats import RenderMode, Splats

SOLID = 0.5
"""Alpha above which expected depth is taken for a surface, as in training."""


def surface_point(
    splats: Splats, camera: Camera, pixel: tuple[int, int], near: float, mode: RenderMode = "default"
) -> FloatArray | None:
    """(3,) in the world: expected depth on the ray through the middle of pixel (column, row).

    None where there is no surface: outside the picture, or alpha <= 0.5. Only the pixel's tile is blended,
    to the very numbers of the whole picture.
    """
    column, row = pixel
    if not (0 <= column < camera.width and 0 <= row < camera.height):
        return None
    rasterizer = Rasterizer(camera.width, camera.height)
    wanted = np.zeros((rasterizer.rows, rasterizer.columns), bool)
    wanted[row // TILE, column // TILE] = True
    rasterizer.forward(splats, camera, near, wanted, mode)
    rendered = rasterizer.rendered(camera.width, camera.height, BLACK)
    if rendered.alpha[row, column] <= SOLID:
        return None
    depth = float(rendered.depth[row, column])
    ray = [(column + 0.5 - camera.cx) / camera.fx, (row + 0.5 - camera.cy) / camera.fy, 1.0]
    pose = camera.world_from_camera
    return np.asarray(pose[:3, :3] @ ray * depth + pose[:3, 3])
