"""Reflections count as what surrounds them, so that `vessel` gives tissue beside them no dark rim."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from enhance import enhance_vessels, highlight_halo, measure
from enhance.image import Float32Image
from enhance.reflections import without_reflections
from tests.enhance.vessel_oracle import filled

TISSUE = (190, 110, 100)


def planes() -> tuple[Float32Image, Float32Image]:
    """Even tissue, what it absorbs and its V, with reflections of several sizes."""
    absorbed, value = np.full((60, 90), 0.5, np.float32), np.full((60, 90), 0.6, np.float32)
    for x, y, radius in ((15, 15, 1), (45, 30, 3), (50, 38, 2), (75, 45, 5)):
        cv2.circle(absorbed, (x, y), radius, 0.0, -1)
        cv2.circle(value, (x, y), radius, 1.0, -1)
    return absorbed, value


def test_reflections_take_on_what_surrounds_them() -> None:
    absorbed, value = planes()
    filled = without_reflections(absorbed, value, 8)
    np.testing.assert_allclose(filled, 0.5, atol=1e-5)
    coarser = cv2.resize(value, (45, 30), interpolation=cv2.INTER_AREA)
    assert without_reflections(absorbed, coarser, 8).shape == absorbed.shape


def test_without_reflections_nothing_is_touched() -> None:
    absorbed, value = planes()
    assert without_reflections(absorbed, np.minimum(value, np.float32(0.9)), 8) is absorbed
    colored = np.full_like(absorbed, 0.5)
    np.testing.assert_array_equal(without_reflections(colored, value, 8), colored)


@pytest.mark.parametrize("shape", [(1, 1), (5, 3), (33, 47), (64, 128), (300, 126)])
@pytest.mark.parametrize("blocks", [1, 2])
def test_kernels_agree_with_the_plain_reading(shape: tuple[int, int], blocks: int) -> None:
    rng = np.random.default_rng(blocks)
    absorbed = cv2.GaussianBlur(rng.uniform(-0.2, 0.6, shape).astype(np.float32), (0, 0), 1)
    value = cv2.GaussianBlur(rng.uniform(-2, 3.2, shape).astype(np.float32), (0, 0), 1).clip(0, 1)
    value = cv2.resize(value, (-(-shape[1] // blocks), -(-shape[0] // blocks)))
    value[0, 0] = 1
    for radius in (4, 8, 15):
        own = without_reflections(absorbed, value, radius)
        np.testing.assert_allclose(own, filled(absorbed, value, radius), atol=1e-6)


def test_all_white_stays_finite() -> None:
    absorbed, value = np.zeros((20, 30), np.float32), np.ones((20, 30), np.float32)
    np.testing.assert_array_equal(without_reflections(absorbed, value, 4), absorbed)


@pytest.mark.parametrize("spots", [1, 2, 4])
def test_tissue_beside_reflections_is_as_without_them(spots: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    plain = np.clip(np.array(TISSUE) + rng.normal(0, 1.0, (160, 200, 3)), 0, 255).astype(np.uint8)
    image = plain.copy()
    seen = np.zeros(plain.shape[:2], np.uint8)
    for place in range(spots):
        cv2.circle(image, (60 + 22 * place, 80), 6, (255, 255, 255), -1)
        cv2.circle(seen, (60 + 22 * place, 80), 10, 1, -1)
    around = (cv2.dilate(seen, np.ones((31, 31), np.uint8)) > 0) & (seen == 0)
    used = measure([plain])
    made, wanted = (enhance_vessels(one, statistics=used).image.astype(int) for one in (image, plain))
    assert np.abs((made - wanted)[around].mean(axis=0)).max() < 1.0
    halo = highlight_halo(made.astype(np.uint8), image)
    monkeypatch.setattr(
        "enhance.vessel_density.without_reflections", lambda absorbed, value, radius: absorbed
    )
    assert 3 * abs(halo) < highlight_halo(enhance_vessels(image, statistics=used).image, image)
