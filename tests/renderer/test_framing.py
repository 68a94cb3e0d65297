"""The camera of a file of splats has all of them in view, but for strays."""

from __future__ import annotations

import numpy as np
import pytest

from renderer.camera import BoolArray
from renderer.deformation.motion import Still
from renderer.framing import framing
from renderer.gaussians import DynamicGaussians
from renderer.splats import Float32Array
from renderer.train.initialize import round_gaussians


def in_view(means: Float32Array) -> BoolArray:
    """(N,) of those whose middle the camera sees."""
    colors = np.full(means.shape, 0.5, np.float32)
    camera = framing(
        DynamicGaussians(round_gaussians(means, np.full(len(means), 0.01), colors, 0.9), Still())
    )
    pixels, depth = camera.project(means.astype(np.float64))
    return np.asarray((depth > 0) & np.all((pixels >= 0) & (pixels <= (camera.width, camera.height)), axis=1))


def test_the_far_end_of_what_is_mostly_elsewhere_is_in_view_and_strays_are_not() -> None:
    random = np.random.default_rng(0)
    body, neck = random.uniform(-0.5, 0.5, (900, 3)), random.uniform(-0.1, 0.1, (100, 3))
    neck[:, 1] = np.linspace(-3, -0.5, 100)
    means = np.float32([*body, *neck])
    assert in_view(means).all()
    means[0] = (40, 0, 0)
    assert in_view(means).sum() == pytest.approx(950, abs=15)
