from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from enhance import ImageError
from enhance.metrics import dvbv_local, dvbv_otsu, saturated_share, vessel_contrast
from tests.enhance.pictures import DTYPES, as_type, vessels


def halves() -> NDArray[np.uint8]:
    """Left half 20 or 40, right half 150 or 210, in equal shares: variances 100 and 900."""
    image = np.empty((20, 20), np.uint8)
    image[:, :10] = np.resize([20, 40], (20, 10))
    image[:, 10:] = np.resize([150, 210], (20, 10))
    return image


def test_otsu_variances_of_two_classes() -> None:
    result = dvbv_otsu(halves())
    assert (result.dv, result.bv, result.ratio) == (900, 100, 9)
    assert dvbv_otsu(np.repeat(halves()[..., None], 3, axis=2)) == result
    assert dvbv_otsu(halves().T) == result


def test_otsu_threshold_is_the_one_of_largest_between_class_variance() -> None:
    grey = vessels()[..., 1]
    best = max(range(255), key=lambda t: between_class_variance(grey, t))
    above = grey > best
    result = dvbv_otsu(grey)
    assert result.dv == pytest.approx(float(grey[above].var()))
    assert result.bv == pytest.approx(float(grey[~above].var()))


def between_class_variance(grey: NDArray[np.uint8], threshold: int) -> float:
    above = grey > threshold
    if not above.any() or above.all():
        return -1.0
    share = above.mean()
    return float(share * (1 - share) * (grey[above].mean() - grey[~above].mean()) ** 2)


def test_grey_is_luma() -> None:
    """BT.601: the two dark and the two bright classes of pure primaries have known greys."""
    primaries = np.array([[(0, 0, 255), (255, 0, 0), (0, 255, 0), (255, 255, 0)]], np.uint8)
    result = dvbv_otsu(primaries)
    assert result.bv == pytest.approx(np.var([29, 76]))
    assert result.dv == pytest.approx(np.var([150, 226]))


def test_undefined_measures_are_nan() -> None:
    flat = np.full((9, 9), 90, np.uint8)
    assert math.isnan(dvbv_otsu(flat).ratio)
    two = np.where(np.arange(9) > 4, 200, 10).astype(np.uint8) * np.ones((9, 1), np.uint8)
    assert (dvbv_otsu(two).dv, dvbv_otsu(two).bv) == (0, 0)
    assert math.isnan(dvbv_otsu(two).ratio)
    assert math.isnan(dvbv_local(flat, flat).dv)
    assert dvbv_local(flat, flat).bv == 0
    assert math.isnan(vessel_contrast(flat, np.zeros((9, 9), bool)))
    assert math.isnan(vessel_contrast(flat, np.ones((9, 9), bool)))
    assert math.isnan(vessel_contrast(np.zeros((9, 9), np.uint8), np.eye(9, dtype=bool)))


def test_local_variances_over_the_originals_detail() -> None:
    rng = np.random.default_rng(3)
    original = np.full((40, 60), 0.5)
    original[:, 30:] += 0.1 * rng.standard_normal((40, 30))
    doubled = 0.5 + 2 * (original - 0.5)
    before, after = (dvbv_local(np.clip(image, 0, 1), original) for image in (original, doubled))
    assert before.dv == pytest.approx((0.1 * 255) ** 2, rel=0.15)
    assert before.dv > 10 * before.bv
    assert after.dv == pytest.approx(4 * before.dv, rel=0.05)
    assert after.ratio == pytest.approx(before.ratio, rel=0.05)


def test_local_threshold_and_window() -> None:
    spot = np.zeros((21, 21), np.uint8)
    spot[10, 10] = 100
    variance = 100**2 * (1 / 25) * (24 / 25)  # the same in each of the 25 windows that hold the spot
    result = dvbv_local(spot, spot, threshold=variance / 2)
    assert result.dv == pytest.approx(variance)
    assert result.bv == pytest.approx(0, abs=1e-9)
    assert math.isnan(dvbv_local(spot, spot, threshold=2 * variance).dv)


def test_contrast_of_a_drawn_vessel() -> None:
    image = np.full((60, 60, 3), (200, 100, 80), np.uint8)
    mask = np.zeros((60, 60), bool)
    mask[:, 28:32] = True
    image[mask, 1] = 60
    image[:, [26, 27, 32, 33], 1] = 80  # blurred edges, left out of the ring
    assert vessel_contrast(image, mask) == pytest.approx(0.4)
    assert vessel_contrast(image[..., 1], mask) == pytest.approx(0.4)
    assert vessel_contrast(image // 2, mask) == pytest.approx(0.4)
    image[:, np.abs(np.arange(60) - 29.5) > 9] = 255  # further than 7 pixels: not the ring either
    assert vessel_contrast(image, mask) == pytest.approx(0.4)
    image[mask, 1] = 150
    assert vessel_contrast(image, mask) == pytest.approx(-0.5)


@pytest.mark.parametrize("dtype", [kind for kind in DTYPES if kind != np.float16])
def test_measures_do_not_depend_on_the_type(dtype: Any) -> None:
    image = vessels()
    same = as_type(image / 255, dtype)
    mask = image[..., 1] < 60
    assert dvbv_otsu(same) == dvbv_otsu(image)
    assert dvbv_local(same, image).ratio == pytest.approx(dvbv_local(image, image).ratio, rel=1e-4)
    assert vessel_contrast(same, mask) == pytest.approx(vessel_contrast(image, mask), rel=1e-5)
    assert saturated_share(same) == saturated_share(image)


def test_saturated_share_counts_any_channel_from_250_on() -> None:
    image = np.zeros((2, 5, 3), np.uint8)
    image[0, 0] = (250, 0, 0)
    image[1, 1] = (10, 20, 255)
    image[1, 2] = (249, 249, 249)
    assert saturated_share(image) == 0.2
    assert saturated_share(image[..., 0]) == 0.1


def test_sizes_must_agree() -> None:
    with pytest.raises(ImageError, match="one size"):
        dvbv_local(vessels(20, 30), vessels(30, 20))
    with pytest.raises(ImageError, match="vessel_mask"):
        vessel_contrast(vessels(20, 30), np.ones((30, 20), bool))
