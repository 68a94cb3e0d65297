from __future__ import annotations

import cv2
import numpy as np
import pytest

from enhance.morphology import opened, step_of


@pytest.mark.parametrize("shape", [(1, 1), (3, 200), (200, 3), (130, 300)])
@pytest.mark.parametrize("radius", [1, 2, 5, 8, 15])
def test_it_is_the_opening_by_a_disc(shape: tuple[int, int], radius: int) -> None:
    plane = np.random.default_rng(radius).normal(size=shape).astype(np.float32)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1,) * 2)
    literal = cv2.morphologyEx(plane, cv2.MORPH_OPEN, disc, borderType=cv2.BORDER_REPLICATE)
    step = np.ptp(plane) / 65535
    wanted = cv2.GaussianBlur(literal, (3, 3), 0.6)
    np.testing.assert_allclose(opened(plane, radius), wanted, rtol=0, atol=0.51 * step + 1e-6)


def test_every_radius_is_opened_at_a_size_that_leaves_its_disc() -> None:
    for radius in range(2, 129):
        assert 128 % step_of(radius) == 0
        assert min(8, radius // 2) <= radius // step_of(radius) <= 15
