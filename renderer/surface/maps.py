"""What one camera sees of a model at one moment, as smooth maps that can be read between pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.clip import BoolImage
from renderer.gaussians import DynamicGaussians
from renderer.paint import painted
from renderer.picking import SOLID
from renderer.rasterize.cpu import render
from renderer.rasterize.rendered import Rendered
from renderer.splats import Float32Array, RenderMode

SMOOTHING: Final = 1.5
"""Standard deviation over which depth is averaged, by the distance between Gaussians in the picture: single
ones stand out of the surface by more than it bends within that."""
FINEST, COARSEST = 0.5, 12.0
"""Of that in pixels."""
LEAST_WEIGHT: Final = 1e-3
"""Share of a neighbourhood that must be seen."""


@dataclass(frozen=True, eq=False)
class Maps:
    """Of a camera with H x W pixels."""

    camera: Camera
    depth: Float32Array
    """(H, W) along +z, smooth; reaches beyond what is seen, for reading between pixels; 0 far from it."""
    seen: BoolImage
    """(H, W), True where there is a surface: alpha above SOLID."""
    color: Float32Array
    """(H, W, 3) RGB, not premultiplied."""


def maps_of(model: DynamicGaussians, time: float, camera: Camera, near: float, mode: RenderMode) -> Maps:
    """Rendered by the numba rasteriser."""
    splats = model.at(time)
    rendered = render(splats, camera, near=near, mode=mode)
    seen = rendered.alpha > SOLID
    sigma = _sigma(seen, len(splats))
    inverse = np.divide(1, rendered.depth, out=np.zeros_like(rendered.depth), where=seen)
    nearness = smoothed(inverse, seen, sigma)
    depth = np.divide(1, nearness, out=np.zeros_like(nearness), where=nearness > 0)
    return Maps(camera, depth, seen, _straight(rendered))


def displacement(
    model: DynamicGaussians,
    times: tuple[float, float],
    camera: Camera,
    near: float,
    mode: RenderMode = "default",
) -> Float32Array:
    """(H, W, 3) how far what `camera` sees at the first of the `times` has gone at the second, in world
    space: blended as the colours of the Gaussians are, then smoothed."""
    first, second = (model.at(time) for time in times)
    rendered = render(painted(first, second.means - first.means), camera, near=near, mode=mode)
    seen = rendered.alpha > SOLID
    return smoothed(_straight(rendered), seen, _sigma(seen, len(model)))


def smoothed(values: Float32Array, seen: BoolImage, sigma: float) -> Float32Array:
    """(H, W) or (H, W, 3) means of what is seen around each pixel; 0 where nothing is."""
    weights = np.asarray(cv2.GaussianBlur(seen.astype(np.float32), (0, 0), sigma), np.float32)
    known = values * (seen if values.ndim == 2 else seen[..., None])
    sums = np.asarray(cv2.GaussianBlur(known.astype(np.float32), (0, 0), sigma), np.float32)
    weights = weights if values.ndim == 2 else weights[..., None]
    return np.divide(sums, weights, out=np.zeros_like(sums), where=weights > LEAST_WEIGHT)


def read(map_: Float32Array, pixels: FloatArray) -> Float32Array:
    """(N,) or (N, C) values at the pixel positions (N, 2), bilinear; beyond the map those of its edge."""
    height, width = map_.shape[:2]
    x = np.clip(np.nan_to_num(pixels[:, 0] - 0.5), 0, width - 1)
    y = np.clip(np.nan_to_num(pixels[:, 1] - 0.5), 0, height - 1)
    left, top = x.astype(np.int64), y.astype(np.int64)
    right, bottom = np.minimum(left + 1, width - 1), np.minimum(top + 1, height - 1)
    tail = (-1,) + (1,) * (map_.ndim - 2)
    across = (x - left).astype(np.float32).reshape(tail)
    down = (y - top).astype(np.float32).reshape(tail)
    upper = map_[top, left] * (1 - across) + map_[top, right] * across
    lower = map_[bottom, left] * (1 - across) + map_[bottom, right] * across
    return np.asarray(upper * (1 - down) + lower * down)


def _sigma(seen: BoolImage, count: int) -> float:
    spacing = math.sqrt(max(int(np.count_nonzero(seen)), 1) / max(count, 1))
    return min(max(SMOOTHING * spacing, FINEST), COARSEST)


def _straight(rendered: Rendered) -> Float32Array:
    alpha = rendered.alpha[..., None]
    return np.divide(rendered.image, alpha, out=np.zeros_like(rendered.image), where=alpha > 0)
