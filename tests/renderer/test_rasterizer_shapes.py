"""What the kernels of the rasteriser, which check no bounds, are kept from."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.rasterize.cpu import BLACK, Rasterizer, render
from tests.renderer.scenes import random_splats

CAMERA = Camera.from_fov(60, 64, 40)
SPLATS = random_splats(30, CAMERA)


def drawn() -> Rasterizer:
    rasterizer = Rasterizer(64, 40)
    rasterizer.forward(SPLATS, CAMERA)
    return rasterizer


@pytest.mark.parametrize("background", [(), (1.0,), (0.1, 0.2, 0.3, 0.4), 0.5, None])
def test_a_background_has_three_numbers(background: Any) -> None:
    with pytest.raises(ValueError, match="expected a background of three numbers, got"):
        render(SPLATS, CAMERA, background)
    nothing = np.zeros((40, 64))
    with pytest.raises(ValueError, match="expected a background of three numbers, got"):
        drawn().set_adjoint(np.zeros((40, 64, 3)), nothing, nothing, background)


def test_pictures_are_no_larger_than_the_planes() -> None:
    assert drawn().rendered(64, 48, BLACK).image.shape == (48, 64, 3)
    for width, height in ((640, 480), (65, 40), (64, 49), (-1, 40)):
        with pytest.raises(ValueError, match=f"expected at most 64x48 pixels, got {width}x{height}"):
            drawn().rendered(width, height, BLACK)


@pytest.mark.parametrize(
    ("image", "alpha", "depth", "said"),
    [
        ((4, 4, 3), (40, 64), (40, 64), r"by_image of shape \(40, 64, 3\), got \(4, 4, 3\)"),
        ((40, 64, 3), (40, 64), (4, 64), r"by_depth of shape \(40, 64\), got \(4, 64\)"),
        ((480, 640, 3), (480, 640), (480, 640), "at most 64x48 pixels, got 640x480"),
    ],
)
def test_gradients_by_a_picture_have_its_shape(image: Any, alpha: Any, depth: Any, said: str) -> None:
    by = [np.zeros(shape) for shape in (image, alpha, depth)]
    with pytest.raises(ValueError, match=said):
        drawn().set_adjoint(*by, BLACK)  # type: ignore[call-arg]


def test_tiles_and_splats_are_those_of_the_picture() -> None:
    with pytest.raises(ValueError, match=r"tile_wanted of shape \(3, 4\), got \(1, 1\)"):
        drawn().forward(SPLATS, CAMERA, tile_wanted=np.ones((1, 1), bool))
    with pytest.raises(ValueError, match=r"means of shape \(30, 3\), got \(31, 3\)"):
        drawn().backward(random_splats(31, CAMERA))
