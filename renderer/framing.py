"""A camera for Gaussians that come without one."""

from __future__ import annotations

import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.gaussians import DynamicGaussians

FIELD_OF_VIEW = 50.0
"""Horizontal, in degrees."""
SIZE = 960, 720
"""Width and height in pixels."""
SEEN = 0.95
"""Share of the Gaussians that the view holds where the others are strays: most files have a few far away."""
STRAYS = 1.25
"""Times as far from which all Gaussians would be in view: beyond, some are strays."""
DEVIATIONS = 2.0
"""Standard deviations of a Gaussian that are to be seen, too."""


def framing(model: DynamicGaussians) -> Camera:
    """Looks along z at the Gaussians at rest, from where it sees all of them, or nearly all where the others
    are strays."""
    camera = Camera.from_fov(FIELD_OF_VIEW, *SIZE)
    if len(model) == 0:
        return camera
    means = model.means.astype(np.float64)
    middle, whole = np.median(means, axis=0), (means.min(axis=0) + means.max(axis=0)) / 2
    reach = DEVIATIONS * np.exp(model.raw.log_scales.max(axis=1).astype(np.float64))
    distance, farther = (
        _distance(camera, means - middle, reach, SEEN),
        _distance(camera, means - whole, reach),
    )
    if farther <= STRAYS * distance:
        middle, distance = whole, farther
    size = float(np.quantile(np.linalg.norm(means - middle, axis=1), SEEN))
    pose = np.eye(4)
    pose[:3, 3] = np.array([0, 0, max(distance, size, 1e-6)]) - middle
    return camera.moved(pose)


def _distance(camera: Camera, means: FloatArray, reach: FloatArray, seen: float = 1.0) -> float:
    """From which the camera sees this share of what reaches so far around (N, 3) positions about 0."""
    x, y, z = means.T
    across, down = np.abs(x) + reach, np.abs(y) + reach
    needed = np.maximum(across * camera.fx / camera.cx, down * camera.fy / camera.cy) - z
    return float(np.quantile(needed, seen))
