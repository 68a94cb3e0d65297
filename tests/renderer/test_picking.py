from __future__ import annotations

import numpy as np
import pytest

from renderer.picking import SOLID, surface_point
from renderer.rasterize.cpu import render
from renderer.splats import Splats
from tests.renderer.scenes import random_splats, turned_camera

CAMERA = turned_camera(70, 53)
NEAR = 0.1


@pytest.fixture(scope="module")
def splats() -> Splats:
    return random_splats(400, CAMERA, seed=3)


def test_the_point_is_where_the_whole_picture_s_depth_puts_it(splats: Splats) -> None:
    rendered = render(splats, CAMERA, near=NEAR)
    world = CAMERA.unproject(rendered.depth)
    found = 0
    for row in range(0, 53, 7):
        for column in range(0, 70, 9):
            point = surface_point(splats, CAMERA, (column, row), NEAR)
            if rendered.alpha[row, column] <= SOLID:
                assert point is None
                continue
            found += 1
            assert point == pytest.approx(world[row, column])
            (at,), (depth,) = CAMERA.project(np.array([point]))
            assert at == pytest.approx((column + 0.5, row + 0.5))
            assert depth == pytest.approx(rendered.depth[row, column])
    assert found > 10


@pytest.mark.parametrize("pixel", [(-1, 0), (0, -1), (70, 0), (0, 53)])
def test_outside_the_picture_is_nothing(splats: Splats, pixel: tuple[int, int]) -> None:
    assert surface_point(splats, CAMERA, pixel, NEAR) is None
