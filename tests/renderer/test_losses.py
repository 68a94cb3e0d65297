"""The terms of the loss that are not of each pixel alone, against literal sums and central differences."""

from __future__ import annotations

import numpy as np
import pytest

from renderer.rasterize.tiles import LEFT, PLANE_DEPTH, PLANE_RED
from renderer.train.variation import add_variation

HEIGHT, WIDTH = 18, 23


def blended(seed: int = 0) -> np.ndarray:
    """(5, H, W) planes with some places where little is drawn."""
    rng = np.random.default_rng(seed)
    planes = rng.uniform(0.1, 0.9, (5, HEIGHT, WIDTH)).astype(np.float32)
    planes[LEFT] = np.where(rng.uniform(size=(HEIGHT, WIDTH)) < 0.2, 0.8, 0.1)
    planes[PLANE_DEPTH] = (1 - planes[LEFT]) * rng.uniform(40, 60, (HEIGHT, WIDTH))
    return planes


def test_variation_is_the_sum_over_neighbours() -> None:
    planes = blended()
    extra = np.zeros((4, HEIGHT, WIDTH), np.float32)
    got = add_variation(planes, 0.3, 20.0, extra)
    color = planes[PLANE_RED : PLANE_RED + 3].astype(np.float64)
    total = np.abs(np.diff(color, axis=1)).sum() + np.abs(np.diff(color, axis=2)).sum()
    drawn = planes[LEFT] < 0.5
    inverse = (1 - planes[LEFT].astype(np.float64)) / planes[PLANE_DEPTH]
    near = sum(
        np.abs(np.diff(inverse, axis=axis))[first & second].sum()
        for axis, first, second in ((0, drawn[:-1], drawn[1:]), (1, drawn[:, :-1], drawn[:, 1:]))
    )
    expected = 0.3 * total / color.size + 20.0 * near / inverse.size
    assert got == pytest.approx(expected, rel=1e-5)


def test_slopes_of_the_variation() -> None:
    planes = blended()
    extra = np.zeros((4, HEIGHT, WIDTH), np.float32)
    add_variation(planes, 0.3, 20.0, extra)
    for y, x in ((0, 0), (5, 7), (HEIGHT - 1, WIDTH - 1), (9, 0)):
        changed = planes.copy()
        changed[PLANE_RED + 1, y, x] += 1e-4
        ahead = add_variation(changed, 0.3, 0.0, np.zeros_like(extra))
        slope = (ahead - add_variation(planes, 0.3, 0.0, np.zeros_like(extra))) / 1e-4
        assert extra[1, y, x] == pytest.approx(slope, abs=2e-5)
    y, x = np.argwhere(planes[LEFT] < 0.5)[11]
    changed, weight = planes.copy(), 1 - planes[LEFT, y, x]
    changed[PLANE_DEPTH, y, x] += 0.01 * weight  # 0.01 in expected depth
    ahead, here = (add_variation(some, 0.0, 20.0, np.zeros_like(extra)) for some in (changed, planes))
    assert extra[3, y, x] == pytest.approx((ahead - here) / 0.01, rel=0.02)
    assert not extra[3][planes[LEFT] > 0.5].any()
