from __future__ import annotations

import numpy as np
import pytest

from renderer.camera import Camera
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
            assert point is not None
            assert point.point == pytest.approx(world[row, column])
            (at,), (depth,) = CAMERA.project(np.array([point.point]))
            assert at == pytest.approx((column + 0.5, row + 0.5))
            assert depth == pytest.approx(rendered.depth[row, column])
    assert found > 10


@pytest.mark.parametrize("pixel", [(-1, 0), (0, -1), (70, 0), (0, 53)])
def test_outside_the_picture_is_nothing(splats: Splats, pixel: tuple[int, int]) -> None:
    assert surface_point(splats, CAMERA, pixel, NEAR) is None


def test_the_spread_is_that_of_the_depths_behind_each_other() -> None:
    """Two sheets, half and half: a sum by hand. One sheet has none."""
    camera = Camera(50.0, 50.0, 16.0, 12.0, 32, 24, np.eye(4))

    def sheet(depth: float, opacity: float) -> Splats:
        size = np.full((1, 3), 40.0, np.float32)
        quats, color = np.array([[1.0, 0, 0, 0]], np.float32), np.zeros((1, 3), np.float32)
        return Splats(
            np.array([[0.0, 0, depth]], np.float32), quats, size, np.array([opacity], np.float32), color
        )

    front, back = sheet(20.0, 0.5), sheet(30.0, 0.8)
    both = Splats(*(np.concatenate(pair) for pair in zip(parts(front), parts(back), strict=True)))
    (alone, seen) = (surface_point(one, camera, (16, 12), NEAR) for one in (sheet(20.0, 0.9), both))
    assert alone is not None
    assert seen is not None
    assert alone.spread == pytest.approx(0.0, abs=0.02)
    weights = np.array([0.5, 0.5 * 0.8]) / 0.9
    mean = weights @ [20.0, 30.0]
    assert seen.point[2] == pytest.approx(mean, rel=1e-3)
    assert seen.spread == pytest.approx(np.sqrt(weights @ (np.array([20.0, 30.0]) - mean) ** 2), rel=0.01)
    assert seen.ray == pytest.approx([0.5 / 50, 0.5 / 50, 1.0])


def parts(splats: Splats) -> tuple[np.ndarray, ...]:
    return splats.means, splats.quats, splats.scales, splats.opacities, splats.colors
