"""Of `vessel`: underexposed images are lit, noise within bounds, and nothing else is touched."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from enhance import ImageError, LiveStatistics, enhance_vessels, measure
from enhance.exposure import BRIGHT, NOTHING, bright_level, exposed, exposure
from enhance.noise import chroma_noise_gain, noise_gain
from enhance.vessel import VESSEL, VesselEnhancer, VesselParams
from tests.enhance.pictures import as_type, vessels
from tests.enhance.test_real_images import FRAMES, read
from tests.enhance.test_vessel import apart

AS_IT_IS = replace(VESSEL, most_exposure=1.0)
DARK = 0.12
"""Of what a frame of good exposure is: its mean is some 15 grey levels."""


def darker(image: NDArray[Any], share: float = DARK, noise: float = 0.0) -> NDArray[np.uint8]:
    """Of 8 bits, with noise of this deviation in grey levels."""
    grain = np.random.default_rng(5).normal(0, noise, image.shape) if noise else 0.0
    return np.rint(np.clip(image * share + grain, 0, 255)).astype(np.uint8)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("share", [0.04, DARK, 0.4])
def test_kernels_agree_with_the_plain_reading_of_underexposed_images(share: float, dtype: type) -> None:
    image = as_type(darker(vessels(), share, noise=1.0) / 255, dtype)
    for given in (image, image[..., 1]):
        for params in (VESSEL, replace(VESSEL, most_exposure=8.0, lift=1.0)):
            difference = apart(given, params)
            assert difference.max() <= 1.01
            assert difference.mean() < 0.02


@pytest.mark.data
@pytest.mark.parametrize("name", FRAMES)
def test_real_frames_are_left_alone_and_their_dark_copies_lit(name: str) -> None:
    image = read(FRAMES[name])
    result, without = (enhance_vessels(image, params) for params in (VESSEL, AS_IT_IS))
    np.testing.assert_array_equal(result.image, without.image)
    dark = darker(image, noise=1.0)
    lit, unlit = (enhance_vessels(dark, params).image for params in (VESSEL, AS_IT_IS))
    assert lit.mean() > 2 * unlit.mean()
    assert (apart(dark, VESSEL) > 1).mean() < 1e-4


def test_vessels_of_an_underexposed_image_are_set_off_by_more_grey_levels() -> None:
    image = vessels(240, 320)
    dark = darker(image, noise=0.5)
    vessel = image[..., 1] < np.quantile(image[..., 1], 0.15)
    given, lit, unlit = (
        float(shown[~vessel].mean()) - float(shown[vessel].mean())
        for shown in (dark, enhance_vessels(dark).image, enhance_vessels(dark, AS_IT_IS).image)
    )
    assert lit > 3 * given
    assert lit > 2 * unlit


@pytest.mark.parametrize("noise", [1.0, 2.0, 3.0])
def test_noise_grows_by_no_more_than_the_exposure(noise: float) -> None:
    """Beyond what Eq 1 and the colours do to an image that is not lit."""
    grain = np.random.default_rng(3).normal(0, noise, (160, 160, 3))
    image = np.rint(np.clip(np.array([28.0, 16.0, 14.0]) + grain, 0, 255)).astype(np.uint8)
    flat = np.ones(image.shape[:2], bool)
    for gain in (noise_gain, chroma_noise_gain):
        lit, unlit = (gain(enhance_vessels(image, p).image, image, flat=flat) for p in (VESSEL, AS_IT_IS))
        assert unlit < lit < VESSEL.most_exposure * unlit


def test_what_a_covered_lens_shows_stays_dark() -> None:
    noise = np.abs(np.random.default_rng(4).normal(0, 1.5, (120, 160, 3)))
    image = np.rint(noise).astype(np.uint8)
    lit, unlit = (enhance_vessels(image, params, pixels="all").image for params in (VESSEL, AS_IT_IS))
    np.testing.assert_array_equal(lit, unlit)
    assert not enhance_vessels(np.zeros((40, 40, 3), np.uint8)).image.any()


def test_a_black_surround_stays_as_it_is() -> None:
    y, x = np.mgrid[:240, :320]
    inside = np.hypot(x - 160, y - 120) < 100
    image = np.where(inside[..., None], darker(vessels(240, 320), 0.2), 0).astype(np.uint8)
    image = image + np.random.default_rng(6).integers(0, 3, image.shape, dtype=np.uint8)
    result = enhance_vessels(image)
    assert result.statistics.field is not None
    assert not result.statistics.field.is_whole
    outside = np.hypot(x - 160, y - 120) > 104
    np.testing.assert_array_equal(result.image[outside], image[outside])
    assert result.image[inside].mean() > 2 * image[inside].mean()


def test_exposure_takes_the_bright_end_to_what_is_bright_enough() -> None:
    for bright in (40.0, 64.0, 95.0):
        times = exposure(bright, 4.0)
        assert 255 * exposed(np.array([bright / 255]), times)[0] == pytest.approx(BRIGHT)
    assert exposure(BRIGHT, 4.0) == exposure(255.0, 4.0) == exposure(None, 4.0) == 1.0
    assert exposure(30.0, 4.0) == 4.0
    assert exposure(0.0, 4.0) == exposure(NOTHING, 4.0) == 1.0
    ends = np.array([exposure(bright, 8.0) for bright in np.linspace(0, 255, 1021)])
    assert np.abs(np.diff(ends)).max() < 0.1  # A stream that gets darker is not lit at once.


def test_the_bright_end_is_what_nine_tenths_do_not_exceed() -> None:
    image = np.full((10, 10, 3), 40, np.uint8)
    image[0] = 250
    assert measure([image]).bright_level == 40
    image[1, 0] = 250
    assert measure([image]).bright_level == 250
    assert bright_level(np.bincount([7], minlength=256).cumsum()) == 7


def test_a_stream_follows_exposure_as_it_follows_brightness() -> None:
    enhancer = VesselEnhancer(LiveStatistics(half_life=1))
    levels = []
    for level in (100, 90, 90):
        enhancer.show(np.full((32, 32, 3), level, np.uint8))
        levels.append(enhancer.enhance().statistics.bright_level)
    assert levels == [100, 95, 92.5]


def test_statistics_without_a_bright_end_light_nothing() -> None:
    """As of records of before."""
    dark = darker(vessels())
    known = measure([dark])
    before = replace(known, bright_level=None)
    results = [enhance_vessels(dark, p, statistics=s).image for p, s in ((VESSEL, before), (AS_IT_IS, known))]
    np.testing.assert_array_equal(*results)
    with pytest.raises(ImageError, match="finite"):
        replace(known, bright_level=float("nan"))


def test_an_image_is_lit_as_often_as_parameters_change() -> None:
    enhancer = VesselEnhancer()
    dark = darker(vessels())
    enhancer.show(dark)
    for most in (6.0, 1.0, 2.0, 6.0):
        params = VesselParams(most_exposure=most)
        np.testing.assert_array_equal(enhancer.enhance(params).image, enhance_vessels(dark, params).image)
