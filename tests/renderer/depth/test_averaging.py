"""Averages over a share of the width: those of wide pictures agree with the direct ones."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from renderer.depth import averaging
from renderer.depth.averaging import averaged


def picture(width: int) -> np.ndarray:
    noise = np.random.default_rng(2).uniform(0, 1, (width // 2, width)).astype(np.float32)
    return noise + np.linspace(0, 2, width, dtype=np.float32)


def test_up_to_a_width_it_is_the_gaussian_itself():
    values = picture(400)
    np.testing.assert_array_equal(averaged(values, 0.1), cv2.GaussianBlur(values, (0, 0), 40))


@pytest.mark.parametrize("width", [1600, 1601, 2000])
def test_beyond_it_is_the_same_within_a_percent(monkeypatch, width):
    values = picture(width)
    monkeypatch.setattr(averaging, "WIDEST", width)
    direct = averaged(values, 0.05)
    monkeypatch.setattr(averaging, "WIDEST", 400)
    blurred: list[tuple[int, ...]] = []
    blur = cv2.GaussianBlur
    monkeypatch.setattr(
        cv2, "GaussianBlur", lambda image, *rest: blurred.append(image.shape) or blur(image, *rest)
    )
    shrunk = averaged(values, 0.05)
    assert blurred == [(round(values.shape[0] * 400 / width), 400)]
    assert shrunk.shape == direct.shape
    assert np.abs(shrunk / direct - 1).max() < 0.01
