"""The oracle is judged too: by the standard library and by plain loops."""

from __future__ import annotations

import colorsys

import numpy as np
import pytest

from enhance import EnhanceParams, reference
from tests.enhance.test_guided_filter import boxes, direct_filter


def test_hsv_is_that_of_the_standard_library() -> None:
    corners = np.stack(np.meshgrid(*[[0, 0.25, 0.5, 1]] * 3), axis=-1).reshape(8, 8, 3)
    for rgb in (corners, np.random.default_rng(1).random((9, 7, 3))):
        hue, chroma, value = reference.hsv_from_rgb(rgb)
        for i, j in np.ndindex(hue.shape):
            assert (hue[i, j] / 6, chroma[i, j], value[i, j]) == pytest.approx(
                colorsys.rgb_to_hsv(*rgb[i, j])
            )
        np.testing.assert_allclose(reference.rgb_from_hsv(hue, chroma, value), rgb, atol=1e-15)


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (12, 11)])
@pytest.mark.parametrize("radius", [1, 3, 30])
def test_windows_and_filter_are_the_definition(shape: tuple[int, int], radius: int) -> None:
    image = np.random.default_rng(2).random(shape)
    np.testing.assert_allclose(reference.window_mean(image, radius), boxes(image, radius), atol=1e-14)
    params = EnhanceParams(subsample=1)
    expected = direct_filter(image, radius, params.eps)
    np.testing.assert_allclose(reference.guided(image, radius, params), expected, atol=1e-11)


def test_enlarging_keeps_planes() -> None:
    y, x = np.mgrid[0:6, 0:9].astype(np.float64)
    large = reference.bilinear(0.3 + 0.1 * y - 0.02 * x, 4)
    rows, columns = np.mgrid[0:24, 0:36]
    plane = 0.3 + 0.1 * ((rows + 0.5) / 4 - 0.5) - 0.02 * ((columns + 0.5) / 4 - 0.5)
    np.testing.assert_allclose(large[2:-2, 2:-2], plane[2:-2, 2:-2], atol=1e-14)
    assert large.min() >= 0.3 - 0.16 - 1e-12
    np.testing.assert_allclose(reference.bilinear(np.full((1, 1), 0.7), 3), 0.7)
