"""A model of each kind of motion."""

from __future__ import annotations

from renderer.deformation.motion import Still
from renderer.gaussians import DynamicGaussians
from tests.renderer import test_fdm, test_gaussians, test_hexplane

COUNT = 150


def models() -> dict[str, DynamicGaussians]:
    """Of COUNT Gaussians each."""
    spline = test_gaussians.model(COUNT)
    plane = DynamicGaussians(test_hexplane.random_gaussians(), test_hexplane.random_motion())
    return {
        "still": DynamicGaussians(spline.raw, Still()),
        "spline": spline,
        "flexible": DynamicGaussians(spline.raw, test_fdm.random_motion(count=COUNT)),
        "hexplane": plane,
    }
