"""Splats in colours that show something else than how they look."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera, FloatArray
from renderer.rotations import matrix
from renderer.splats import Splats


def painted(splats: Splats, colors: NDArray[np.floating]) -> Splats:
    """In other colours (N, 3), the same from everywhere."""
    return replace(splats, colors=colors.astype(np.float32), harmonics=splats.harmonics[:, :0])


def by_normal(splats: Splats, camera: Camera) -> Splats:
    """The shortest axis, turned to face the camera: red right, green up, blue to the camera; 0.5 is 0."""
    towards = _shortest_axes(splats) @ camera.camera_from_world[:3, :3].T
    local = splats.means @ camera.camera_from_world[:3, :3].T + camera.camera_from_world[:3, 3]
    away = (towards * local).sum(axis=1, keepdims=True) > 0
    towards = np.where(away, -towards, towards) * [1.0, -1.0, -1.0]
    return painted(splats, 0.5 + 0.5 * towards)


def by_motion(splats: Splats, first: Splats) -> Splats:
    """How far each has gone from where it was in `first`, in scene units, in all three channels."""
    way = np.linalg.norm(splats.means - first.means, axis=1)
    return painted(splats, np.repeat(way[:, None], 3, axis=1))


def _shortest_axes(splats: Splats) -> FloatArray:
    """(N, 3) unit vectors in the world."""
    quats = splats.quats.astype(np.float64)
    lengths = np.linalg.norm(quats, axis=1, keepdims=True)
    turned = matrix((quats / np.where(lengths > 0, lengths, 1)).T)
    return turned[:, splats.scales.argmin(axis=1), np.arange(len(splats))].T
