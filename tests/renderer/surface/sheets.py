"""A flat sheet of Gaussians that drifts as a whole, with a hole in it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from tests.renderer.splines import without_nodes

CAMERA = Camera(fx=120, fy=120, cx=48, cy=36, width=96, height=72)
NEAR = 0.05
WAY = np.array([1.5, -1.0, 2.0])
"""From the beginning to the end of the clip, evenly."""
SLOPE = 0.1
"""Of depth along x."""
HOLE = 6.0
"""Radius about the middle where there are no Gaussians."""


def depth_at(points: NDArray[np.float64], time: float) -> NDArray[np.float64]:
    """Of the sheet at x of the points (N, 3)."""
    moved = points - time * WAY
    return np.asarray(50 + SLOPE * moved[:, 0] + time * WAY[2])


def sheet(spacing: float = 0.8) -> DynamicGaussians:
    """Red to the left, green to the right."""
    x, y = (axis.ravel() for axis in np.meshgrid(*(np.arange(-30, 30, spacing),) * 2))
    kept = np.hypot(x, y) > HOLE
    x, y = x[kept], y[kept]
    count, controls = len(x), 4
    half = -np.arctan(SLOPE) / 2
    means = np.stack([x, y, 50 + SLOPE * x], axis=1).astype(np.float32)
    colors = np.where(x[:, None] < 0, [0.8, 0.1, 0.1], [0.1, 0.8, 0.1]).astype(np.float32)
    raw = RawGaussians(
        means=means,
        quats=np.tile([np.cos(half), 0, np.sin(half), 0], (count, 1)).astype(np.float32),
        log_scales=np.log(np.full((count, 3), 0.6, np.float32) * np.float32([1, 1, 0.1])),
        opacity_logits=np.full(count, 4, np.float32),
        colors=colors,
        harmonics=np.zeros((count, 0, 3), np.float32),
    )
    # Values of a uniform cubic spline of four controls that is the straight line from 0 to 1.
    line = np.arange(controls)[:, None] - 1.0
    motion = without_nodes(np.broadcast_to(line * WAY, (count, controls, 3)).astype(np.float32).copy())
    return DynamicGaussians(raw, motion)


def around(count: int) -> tuple[Camera, ...]:
    """Cameras that move sideways and look at the middle."""
    cameras = []
    for place in np.linspace(-10, 10, count):
        angle = np.arctan2(place, 50)
        turn = np.eye(4)
        turn[:3, :3] = [
            [np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]
        ]  # fmt: skip
        turn[:3, 3] = -turn[:3, :3] @ [place, 0, 0]
        cameras.append(CAMERA.moved(turn))
    return tuple(cameras)
