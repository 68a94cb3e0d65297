"""The near plane of a scene: a share of its distance, so that units do not matter."""

from __future__ import annotations

import numpy as np

from renderer.camera import Camera
from renderer.deformation.windowed_motion import WindowedMotion
from renderer.gaussians import DynamicGaussians

NEAR_SHARE = 1e-3
"""Near plane as a share of the scene size."""


def near_plane(model: DynamicGaussians, camera: Camera) -> float:
    """The near plane that training used, up to rounding: a share of the model's median depth."""
    return NEAR_SHARE * middle_distance(model, camera)


def middle_distance(model: DynamicGaussians, camera: Camera) -> float:
    """Median depth along the camera's axis of the Gaussians before it, of a model in windows of those that
    there are at first, if any; 1 when there is none."""
    pose = camera.camera_from_world
    means = model.means
    if isinstance(model.motion, WindowedMotion):
        first = model.motion.rows_at(0.0)
        means = means[first] if len(first) else means
    depth = means @ pose[2, :3] + pose[2, 3]
    before = depth[depth > 0]
    return float(np.median(before)) if len(before) else 1.0
