"""One moment of a model as a picture: drawn on the CPU, how near, and its depth in colours."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.splats import Float32Array, Splats


@dataclass(frozen=True, eq=False)
class Drawn:
    """image (H, W, 3) RGB, not clipped; depth (H, W) expected depth in scene units, 0 where nothing is."""

    image: Float32Array
    depth: Float32Array

    @property
    def bytes(self) -> NDArray[np.uint8]:
        """(H, W, 3) rounded to 8 bits."""
        rounded: NDArray[np.uint8] = np.rint(np.clip(self.image, 0.0, 1.0) * 255.0).astype(np.uint8)
        return rounded


def colored_depth(depth: Float32Array) -> tuple[NDArray[np.uint8], tuple[float, float]]:
    """(H, W, 3) viridis from near (yellow) to far, black where nothing is, and the range it spans.

    The range is the 1st to 99th percentile, so that a few stray splats do not flatten the picture.
    """
    seen = depth > 0
    if not seen.any():
        return np.zeros((*depth.shape, 3), dtype=np.uint8), (0.0, 0.0)
    near, far = (float(value) for value in np.percentile(depth[seen], (1, 99)))
    level = np.clip((far - depth) / max(far - near, 1e-12), 0.0, 1.0)
    colors = cv2.applyColorMap(np.rint(level * 255).astype(np.uint8), cv2.COLORMAP_VIRIDIS)
    picture = cv2.cvtColor(colors, cv2.COLOR_BGR2RGB).astype(np.uint8)
    picture[~seen] = 0
    return picture, (near, far)


def draw_on_cpu(splats: Splats, camera: Camera, near: float) -> Drawn:
    from renderer.rasterize.cpu import render

    rendered = render(splats, camera, near=near)
    return Drawn(rendered.image, rendered.depth)
