"""Colours that are faint beside their noise are not stretched; clear ones are, as the equations have it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from enhance import EnhanceParams, LiveStatistics, chroma_noise_gain, enhance, measure
from enhance.reference import enhance_reference
from enhance.saturation import CLEAR, FAINT, MOST_GAIN, Saturation, color_share, gain_at_mean, stretch
from tests.enhance.pictures import ByteImage, vessels


def faint(noise: float, chroma: float = 0.06, seed: int = 0) -> ByteImage:
    """(H, W, 3): nearly grey tissue with noise of so many grey levels in each channel."""
    y, x = np.mgrid[:180, :240]
    light = 150 + 30 * np.sin(x / 40) + 20 * np.cos(y / 30)
    color = np.stack((light, (1 - chroma) * light, (1 - chroma) * light), axis=2)
    color += np.random.default_rng(seed).normal(0, noise, color.shape)
    return np.rint(np.clip(color, 0, 255)).astype(np.uint8)


@given(st.floats(0.02, 0.98))
def test_the_gain_is_the_slope_of_the_stretch_at_the_mean(mean: float) -> None:
    step = 1e-3 * min(mean, 1 - mean)
    around = np.array([[mean - step, mean + step]], np.float64)
    low, high = stretch(Saturation(around, 1 - around), mean, 1.0)[0]  # type: ignore[arg-type]
    assert gain_at_mean(mean) == pytest.approx((high - low) / (2 * step), rel=2e-3, abs=1e-3)


@given(st.floats(0, 1), st.floats(0, 100))
def test_noise_never_grows_by_more_than_the_bound(mean: float, snr: float) -> None:
    share = color_share(mean, snr)
    assert 0 <= share <= 1
    bound = 1 + (MOST_GAIN - 1) * min(max((snr - FAINT) / (CLEAR - FAINT), 0), 1)
    if share > 0:
        assert 1 + share * (gain_at_mean(mean) - 1) <= bound * (1 + 1e-9)
    assert color_share(mean, snr + 1) >= share


def test_clear_colours_are_stretched_as_the_equations_have_it() -> None:
    for mean in (0.3, 0.5, 0.7):
        assert color_share(mean, CLEAR) == color_share(mean, None) == 1
    assert color_share(0.5, FAINT) == 0


@pytest.mark.parametrize("noise", [2.0, 4.0, 8.0])
def test_faint_colours_are_not_lit_up(noise: float) -> None:
    image = faint(noise)
    automatic, literal = (
        enhance(image, EnhanceParams(p=0, z=1)),
        enhance(image, EnhanceParams(p=0, z=1, d_factor=1)),
    )
    gains = [chroma_noise_gain(result.image, image) for result in (automatic, literal)]
    assert gains[0] <= 1.2
    assert gains[1] > 2 * gains[0]
    assert automatic.statistics.color < 0.1
    assert literal.statistics.color == 1


def test_a_clear_picture_is_as_the_equations_have_it() -> None:
    y, x = np.mgrid[:180, :240]
    image = np.stack((170 + 20 * np.sin(x / 9), 90 + 10 * np.sin(y / 7), 80 + 0 * x), axis=2).astype(np.uint8)
    automatic, literal = enhance(image), enhance(image, EnhanceParams(d_factor=1.0))
    assert automatic.statistics.color == 1
    assert np.array_equal(automatic.image, literal.image)


@pytest.mark.parametrize("image", [vessels(), faint(2), faint(1, 0.15), faint(5, 0.4)], ids="abcd")
def test_it_is_measured_and_used_as_in_the_reference(image: ByteImage) -> None:
    params = EnhanceParams(omit_below=0.0)
    result = enhance(image / 255, params)
    exact, used = enhance_reference(image / 255, params)
    assert result.statistics.chroma_snr == pytest.approx(used.chroma_snr, rel=1e-5)
    assert enhance(image, params).statistics.chroma_snr == pytest.approx(used.chroma_snr, rel=1e-5)
    assert result.statistics.color == pytest.approx(used.color, abs=1e-6)
    assert 255 * np.abs(result.image - exact).max() < 0.02


def test_a_mask_leaves_out_what_is_not_tissue() -> None:
    image = faint(0.5, 0.5)
    image[:, :120] = faint(9, 0.02)[:, :120]
    keep = np.zeros(image.shape[:2], bool)
    keep[:, 126:] = True
    whole, kept = enhance(image).statistics, enhance(image, tissue_mask=keep).statistics
    assert whole.chroma_snr is not None
    assert kept.chroma_snr is not None
    assert kept.chroma_snr > 1.5 * whole.chroma_snr


def test_a_clip_has_the_mean_of_its_images_and_a_stream_moves_towards_it() -> None:
    images = [faint(1, 0.3), faint(6, 0.1, seed=1)]
    single = [measure([image]).chroma_snr for image in images]
    assert single[0] is not None
    assert single[1] is not None
    assert measure(images).chroma_snr == pytest.approx(sum(single) / 2)  # type: ignore[arg-type]
    first, second = (enhance(image).statistics for image in images)
    between = LiveStatistics(half_life=1).follow(first, second).chroma_snr
    assert between == pytest.approx(sum(single) / 2)  # type: ignore[arg-type]


def test_where_nothing_is_measured_nothing_is_said() -> None:
    assert enhance(vessels()[..., 0]).statistics.chroma_snr is None
    assert enhance(vessels(), EnhanceParams(d_factor=0.7)).statistics.chroma_snr is None
    assert enhance(vessels()[:5, :5]).statistics.chroma_snr is None
    assert math.isinf(gain_at_mean(0.0))
    assert color_share(0.0, None) == color_share(1.0, None) == 0


def test_statistics_that_were_measured_without_serve_all_the_same() -> None:
    used = enhance(vessels(), EnhanceParams(d_factor=0.7)).statistics
    assert enhance(vessels(), statistics=used).statistics.color == color_share(used.saturation_mean, None)
    again = enhance(vessels(), EnhanceParams(d_factor=0.7), statistics=replace(used, color=0.3))
    assert again.statistics.color == 1
