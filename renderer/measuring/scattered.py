"""Gaussians scattered over a view: what speed is measured on, of any number and size."""

from __future__ import annotations

import numpy as np

from renderer.camera import Camera
from renderer.splats import Splats


def scattered(width: int, height: int, count: int) -> tuple[Splats, Camera]:
    """Depth U(40, 120), a focal length of 560 px at width 640 (scaled with the width), standard deviations on
    screen of U(2, 4) px times 10^U(-1, 0) along each axis, opacity U(0.1, 0.9), random colours and
    rotations, by seed 0."""
    rng = np.random.default_rng(0)
    focal = 560.0 * width / 640
    camera = Camera(focal, focal, width / 2, height / 2, width, height)
    depth = rng.uniform(40, 120, count)
    pixels = rng.uniform(0, 1, (count, 2)) * (width, height)
    means = np.column_stack([(pixels - (width / 2, height / 2)) / focal * depth[:, None], depth])
    sigma = rng.uniform(2, 4, (count, 1)) * 10.0 ** rng.uniform(-1, 0, (count, 3))
    splats = Splats(
        means=means.astype(np.float32),
        quats=rng.normal(size=(count, 4)).astype(np.float32),
        scales=(sigma * depth[:, None] / focal).astype(np.float32),
        opacities=rng.uniform(0.1, 0.9, count).astype(np.float32),
        colors=rng.uniform(0, 1, (count, 3)).astype(np.float32),
    )
    return splats, camera
