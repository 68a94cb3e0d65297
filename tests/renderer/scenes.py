"""Random scenes that several tests share."""

from __future__ import annotations

import numpy as np

from renderer.camera import Camera
from renderer.splats import Splats


def random_splats(
    count: int, camera: Camera, seed: int = 0, sigma: tuple[float, float] = (1.0, 4.0)
) -> Splats:
    """Gaussians spread over the view at depths 40 to 120, axes within 10:1, `sigma` in pixels."""
    rng = np.random.default_rng(seed)
    z = rng.uniform(40, 120, count)
    u, v = rng.uniform(0, camera.width, count), rng.uniform(0, camera.height, count)
    local = np.stack([(u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z], axis=1)
    pose = camera.world_from_camera
    pixels = rng.uniform(*sigma, (count, 1)) * 10 ** rng.uniform(-1, 0, (count, 3))
    return Splats(
        means=(local @ pose[:3, :3].T + pose[:3, 3]).astype(np.float32),
        quats=rng.normal(size=(count, 4)).astype(np.float32),
        scales=(pixels * (z / camera.fx)[:, None]).astype(np.float32),
        opacities=rng.uniform(0.1, 0.95, count).astype(np.float32),
        colors=rng.uniform(0, 1, (count, 3)).astype(np.float32),
    )


def turned_camera(width: int, height: int, focal: float = 80.0) -> Camera:
    """A camera with principal point off the centre, fx != fy, turned about a skew axis and moved."""
    axis = np.array([0.3, -0.8, 0.5]) / np.linalg.norm([0.3, -0.8, 0.5])
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    matrix = np.eye(4)
    matrix[:3, :3] = np.eye(3) + np.sin(0.7) * cross + (1 - np.cos(0.7)) * cross @ cross
    matrix[:3, 3] = (3.0, -2.0, 5.0)
    return Camera(focal, focal * 1.1, width * 0.42, height * 0.57, width, height, matrix)
