"""The reference picture of splats, and how far another is from it in grey levels."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.rasterize.reference import Rendered, rasterize_reference
from renderer.splats import RenderMode, Splats

FloatImage = NDArray[np.float32] | NDArray[np.float64]


def reference(
    splats: Splats,
    camera: Camera,
    background: tuple[float, float, float] = (0.0, 0.0, 0.0),
    near: float = 0.01,
    mode: RenderMode = "default",
) -> Rendered:
    splats = splats.seen_from(camera.position)
    fields = (splats.means, splats.quats, splats.scales, splats.opacities, splats.colors)
    means, quats, scales, opacities, colors = (torch.from_numpy(field) for field in fields)
    return rasterize_reference(
        means, quats, scales, opacities, colors, camera, background, near=near, mode=mode
    )


def psnr(image: FloatImage, oracle: FloatImage) -> float:
    """Peak signal-to-noise ratio in dB, infinite when the pictures are equal."""
    error = float(np.mean((image.astype(np.float64) - oracle) ** 2))
    return float("inf") if error == 0 else -10 * float(np.log10(error))


def levels(image: FloatImage, oracle: FloatImage, quantile: float) -> float:
    """That quantile of the absolute error in 8-bit grey levels."""
    return float(np.quantile(np.abs(image.astype(np.float64) - oracle), quantile)) * 255
