"""A camera for Gaussians that come without one."""

from __future__ import annotations

import numpy as np

from renderer.camera import Camera
from renderer.gaussians import DynamicGaussians

FIELD_OF_VIEW = 50.0
"""Horizontal, in degrees."""
SIZE = 960, 720
"""Width and height in pixels."""
SEEN = 0.95
"""Share of the Gaussians that the view holds: a few strays are far away in most files."""
DEVIATIONS = 2.0
"""Standard deviations of a Gaussian that are to be seen, too."""


def framing(model: DynamicGaussians) -> Camera:
    """Looks along z at the middle of the Gaussians at rest, from where it sees nearly all of them."""
    camera = Camera.from_fov(FIELD_OF_VIEW, *SIZE)
    if len(model) == 0:
        return camera
    middle = np.median(model.means.astype(np.float64), axis=0)
    x, y, z = (model.means - middle).T
    reach = DEVIATIONS * np.exp(model.raw.log_scales.max(axis=1).astype(np.float64))
    across, down = np.abs(x) + reach, np.abs(y) + reach
    needed = np.maximum(across * camera.fx / camera.cx, down * camera.fy / camera.cy) - z
    distance = float(np.quantile(needed, SEEN))
    size = float(np.quantile(np.linalg.norm(model.means - middle, axis=1), SEEN))
    pose = np.eye(4)
    pose[:3, 3] = np.array([0, 0, max(distance, size, 1e-6)]) - middle
    return camera.moved(pose)
