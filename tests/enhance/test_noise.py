"""Noise gains: against noise that is known, and whatever is clipped."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from enhance import ImageError
from enhance.noise import chroma_noise_gain, noise_gain
from tests.enhance.pictures import ByteImage, vessels

GAINS = (noise_gain, chroma_noise_gain)
WHITE, BLACK = 1.0, 0.0
Colors = NDArray[np.float64]


def noisy(deviation: float = 0.012) -> Colors:
    """(120, 160, 3): lit from one side, no value clipped."""
    light = np.linspace(0.3, 0.6, 160)[None, :, None] * (1.0, 0.8, 0.7) + np.zeros((120, 1, 1))
    return light + np.random.default_rng(6).normal(0, deviation, light.shape)


def subsampled(gain: float, deviation: float = 0.6, luma: float = 1.5) -> ByteImage:
    """(240, 320, 3) as of 4:2:0 video: colours interpolated from one in 2 x 2 pixels, whose noise has so many
    grey levels' deviation, times `gain`; noise of brightness is that of every pixel, whatever the gain."""
    rng = np.random.default_rng(3)
    noise, grey = rng.normal(0, gain * deviation, (2, 120, 160)), rng.normal(0, luma, (240, 320))
    grey += np.linspace(100, 140, 320)
    blue, red = (cv2.resize(mean + plane, (320, 240)) for mean, plane in zip((-12, 25), noise, strict=True))
    colors = (grey + 1.402 * red, grey - 0.344 * blue - 0.714 * red, grey + 1.772 * blue)
    return np.stack(colors, axis=2).round().astype(np.uint8)


@pytest.mark.parametrize("gain", [0.5, 1.0, 3.0])
def test_noise_gain_is_the_ratio_of_the_noise(gain: float) -> None:
    """Planes, a step and another brightness are no noise; what is masked or structured is not looked at."""
    rng = np.random.default_rng(8)
    noise = rng.normal(0, 0.01, (120, 120, 3))
    x = np.linspace(0.4, 0.6, 120)[None, :, None] + np.zeros((120, 1, 3))
    x[60:] += 0.1
    after = 0.6 * x + 0.1 + gain * noise
    assert noise_gain(after, x + noise) == pytest.approx(gain, rel=0.03)
    mask = np.zeros((120, 120), bool)
    mask[:50] = True
    after[60:] += rng.normal(0, 0.2, (60, 120, 3)).clip(-0.1, 0.1)
    assert noise_gain(after, x + noise, tissue_mask=mask) == pytest.approx(gain, rel=0.05)


def test_ties_among_whole_grey_levels_do_not_move_noise_gains() -> None:
    """Of an image of whole grey levels, many responses are the third quartile itself."""
    noise = np.random.default_rng(4).normal(0, 1.2, (120, 120, 3))
    image = (120 + noise).round() / 255
    for scale in (0.9, 0.7, 0.5):
        assert noise_gain(scale * image, image) == pytest.approx(scale, rel=1e-3)
        assert chroma_noise_gain(scale * image, image) == pytest.approx(scale, rel=1e-3)
    levels = [gain(0.7 * image, image, cut="by level") for gain in GAINS]
    assert levels != pytest.approx([0.7, 0.7], rel=0.02)


def test_noise_is_cut_in_one_of_three_ways() -> None:
    line = "expected cut to be 'unclipped' or 'by rank' or 'by level', got 'by_rank'"
    for gain in GAINS:
        with pytest.raises(ImageError, match=line):
            gain(vessels(), vessels(), cut="by_rank")  # type: ignore[arg-type]


def test_noise_gain_is_undefined_without_noise_or_without_tissue() -> None:
    flat = np.full((20, 20, 3), 0.5)
    assert math.isnan(noise_gain(flat, flat))
    assert math.isnan(noise_gain(vessels(), vessels(), tissue_mask=np.zeros((120, 150), bool)))
    assert noise_gain(vessels(), vessels()) == 1
    ramp = np.add.outer(np.linspace(0.2, 0.5, 48), np.linspace(0.1, 0.4, 64))[..., None].repeat(3, axis=2)
    noisy = ramp + np.random.default_rng(2).normal(0, 1e-3, ramp.shape)
    for gain in GAINS:
        assert math.isnan(gain(noisy, ramp * (1.0, 0.9, 0.8)))  # Rounding of floats is no noise.
    rounded = (ramp * 65535).round() / 65535
    assert noise_gain(rounded, rounded) == 1


@pytest.mark.parametrize("clipped", [WHITE, BLACK])
@pytest.mark.parametrize("scale", [0.5, 1.3])
def test_what_is_clipped_in_either_image_changes_nothing(scale: float, clipped: float) -> None:
    """Half of it, or one pixel in fifty, or one channel."""
    before, after = noisy(), scale * noisy()
    half, few = (np.zeros(before.shape, bool) for _ in range(2))
    half[:, 80:], few[::10, ::5] = True, True
    for gain in GAINS:
        assert gain(after, before) == pytest.approx(scale, rel=1e-3)
        for where in (half, few):
            assert gain(np.where(where, clipped, after), before) == pytest.approx(scale, rel=1e-3)
            assert gain(after, np.where(where, clipped, before)) == pytest.approx(scale, rel=1e-3)
        one = after.copy()
        one[..., 0] = clipped
        assert gain(one, before) == pytest.approx(scale, rel=1e-3)
        assert gain(np.where(half, clipped, after), before, cut="by rank") < 0.8 * scale


def test_a_response_is_left_out_where_any_pixel_of_it_is_clipped() -> None:
    """A clipped pixel in each 3 x 3 leaves none."""
    before = noisy()[:39, :60]
    after = before.copy()
    after[1::3, 1::3] = WHITE
    assert all(math.isnan(gain(after, before)) for gain in GAINS)
    after[1::6, 1::3] = before[1::6, 1::3]
    assert noise_gain(after, before) == pytest.approx(1)


@pytest.mark.parametrize("luma", [0.5, 1.5])
@pytest.mark.parametrize("gain", [0.5, 2.0, 3.0])
def test_chroma_noise_of_subsampled_colours_is_measured_beyond_rounding(gain: float, luma: float) -> None:
    """Pixel by pixel, rounding is compared, whatever the noise."""
    before, after = subsampled(1, luma=luma), subsampled(gain, luma=luma)
    assert chroma_noise_gain(after, before) == pytest.approx(gain, rel=0.1)
    assert chroma_noise_gain(after, before, cut="by rank") != pytest.approx(gain, rel=0.2)


def test_chroma_noise_that_is_far_apart_is_found() -> None:
    """Colours that a codec holds still over 8 pixels: the noise is 0 nearly everywhere, and is there."""
    planes = np.random.default_rng(2).normal(0, 3, (2, 30, 40)).repeat(8, axis=1).repeat(8, axis=2)
    grey = np.full((240, 320), 120.0)
    before, after = (
        np.stack((grey + scale * planes[0], grey, grey + scale * planes[1]), axis=2).round().astype(np.uint8)
        for scale in (1, 2)
    )
    assert chroma_noise_gain(after, before) == pytest.approx(2, rel=0.05)


def test_nothing_is_measured_only_where_nothing_can_be() -> None:
    before = noisy()
    for gain in GAINS:
        assert math.isnan(gain(np.full(before.shape, WHITE), before))
        assert math.isnan(gain(before, np.full(before.shape, BLACK)))
        assert math.isfinite(gain(before[:3, :4], before[:3, :4]))
    grey = before[..., :1].repeat(3, axis=2)
    assert math.isnan(chroma_noise_gain(before, grey))
    assert math.isnan(chroma_noise_gain(before[..., 0], before[..., 0]))
    assert noise_gain(grey, grey) == 1


def test_cuts_of_before_measure_what_they_did() -> None:
    """As of 0.5.0."""
    before = vessels()
    after = np.clip(1.6 * (before.astype(float) - 60), 0, 255).astype(np.uint8)
    found = [gain(after, before, cut=cut) for gain in GAINS for cut in ("by rank", "by level")]
    assert found == pytest.approx([1.3663455, 1.3659021, 1.4769951, 1.4770169], rel=1e-6)
