from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import pytest

from enhance.baselines import (
    BASELINES,
    TAO_STAND_INS,
    _blurred,
    aindane,
    aindane_green,
    clahe,
    jiang2019,
    msrcr,
    unsharp,
    wang2020,
)
from enhance.image import ImageError
from tests.enhance.pictures import ByteImage, vessels

Method = Callable[[ByteImage], ByteImage]
SHAPES = ((1, 1), (1, 30), (3, 2), (47, 64))


@pytest.mark.parametrize("name", BASELINES)
@pytest.mark.parametrize("shape", SHAPES)
def test_shape_and_type_are_kept_and_the_input_too(name: str, shape: tuple[int, int]) -> None:
    image = vessels(*shape)
    before = image.copy()
    result = BASELINES[name](image)
    assert (result.shape, result.dtype) == (image.shape, np.uint8)
    assert np.array_equal(image, before)


@pytest.mark.parametrize("name", BASELINES)
def test_extremes_give_numbers_without_warnings(name: str) -> None:
    for level in (0, 1, 128, 255):
        image = np.full((20, 24, 3), level, np.uint8)
        result = BASELINES[name](image)
        assert np.ptp(result.reshape(-1, 3), axis=0).max() <= 1, (name, level)


@pytest.mark.parametrize("method", [unsharp, aindane, aindane_green, wang2020, jiang2019])
def test_black_stays_black(method: Method) -> None:
    image = vessels()
    image[40:90, 20:70] = 0
    assert method(image)[55:75, 35:55].max() <= 1


@pytest.mark.parametrize("method", [clahe, unsharp, aindane, aindane_green, msrcr, jiang2019, wang2020])
def test_every_method_changes_a_picture(method: Method) -> None:
    image = vessels()
    assert np.abs(method(image).astype(int) - image).mean() > 1


@pytest.mark.parametrize("method", [clahe, unsharp, jiang2019])
def test_local_contrast_grows(method: Method) -> None:
    image = vessels()
    slope = [
        np.abs(np.diff(picture[..., 1].astype(float), axis=1)).mean() for picture in (image, method(image))
    ]
    assert slope[1] > 1.2 * slope[0]


def test_unsharp_adds_the_difference_to_the_blur() -> None:
    image = np.full((41, 41, 3), 100, np.uint8)
    image[20, 20] = 110
    result = unsharp(image).astype(int)
    peak = 1 / (2 * np.pi * 9)
    assert abs(int(result[20, 20, 0]) - (100 + 10 * (2 - peak))) <= 1
    assert np.all(result[:5] == 100)


def test_wang_stretches_green_by_the_printed_map() -> None:
    """Two greys: no saturation, so only Eq (G' = 1 / (1 + d (1 / G - 1)^2)) acts."""
    image = np.full((2, 2, 3), 102, np.uint8)
    image[0] = 204
    d = 0.6**2 * (3 - 1.2) / (0.4**2 * 2.2)
    expected = [1 / (1 + d * (1 / green - 1) ** 2) for green in (0.8, 0.4)]
    np.testing.assert_allclose(wang2020(image)[:, 0, 1], [round(255 * g) for g in expected], atol=1)


def test_wang_moves_red_and_blue_as_far_as_green() -> None:
    image = vessels()
    moved = wang2020(np.repeat(image[..., 1:2], 3, axis=2))
    assert np.array_equal(moved[..., 0], moved[..., 1])


def test_aindane_of_a_flat_grey_is_its_brightness_curve() -> None:
    """Surround = pixel, so E = 1; L = 60 gives z = 0.1."""
    value, z = 60 / 255, 0.1
    lifted = (value ** (0.75 * z + 0.25) + 0.4 * (1 - z) * (1 - value) + value ** (2 - z)) / 2
    assert np.all(aindane(np.full((9, 9, 3), 60, np.uint8)) == round(255 * lifted))


def test_aindane_limits_the_gain() -> None:
    image = np.full((40, 40, 3), 3, np.uint8)
    image[:, 20:] = 30
    assert aindane(image)[:, :10].max() <= 12


def test_retinex_evens_out_illumination() -> None:
    light = np.linspace(0.3, 1.0, 400)[None, :, None]
    texture = 0.6 + 0.1 * np.sin(np.arange(400) / 2)[None, :, None]
    image = np.rint(255 * np.broadcast_to(light * texture, (200, 400, 3))).astype(np.uint8)
    blocks = [picture[100, :, 0].astype(float).reshape(-1, 40) for picture in (image, msrcr(image))]
    before, after = (np.ptp(block.mean(axis=1)) / block.std(axis=1).mean() for block in blocks)
    assert after < 0.5 * before


@pytest.mark.parametrize("sigma", [3.0, 15.0, 40.0])
def test_wide_gaussians_at_reduced_size_are_gaussians(sigma: float) -> None:
    image = np.tile(vessels(120, 150)[..., 1], (2, 2)).astype(np.float32) / 255
    exact = cv2.GaussianBlur(image, (0, 0), sigma, borderType=cv2.BORDER_REFLECT)
    assert np.abs(_blurred(image, sigma) - exact).max() < 0.03 * np.ptp(exact)


def test_stand_ins_are_methods() -> None:
    assert set(TAO_STAND_INS) < set(BASELINES)
    assert not any("tao" in name for name in BASELINES)


@pytest.mark.parametrize("name", BASELINES)
def test_what_is_no_array_is_refused(name: str) -> None:
    nothing: Any = "x"
    with pytest.raises(ImageError, match=r"expected an RGB image of shape \(H, W, 3\) and uint8, got str"):
        BASELINES[name](nothing)


@pytest.mark.parametrize("name", BASELINES)
def test_masked_arrays_are_refused(name: str) -> None:
    masked = np.ma.masked_greater(np.full((8, 8, 3), 100, np.uint8), 90)
    with pytest.raises(ImageError, match="and uint8, got MaskedArray"):
        BASELINES[name](masked)
