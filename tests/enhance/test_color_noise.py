"""Coarse noise of colour is told from tissue, and `vessel` makes no freckles of it."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from enhance import ImageError, LiveStatistics, enhance, enhance_vessels, measure, vessel, vessel_cnr
from enhance.color_noise import coarse_share
from enhance.field import EVERYWHERE
from enhance.reference import enhance_reference
from enhance.ridges import vessel_mask
from enhance.vessel import VESSEL, VesselEnhancer
from enhance.vessel_first_pass import first_pass
from tests.enhance.pictures import ByteImage, as_type, images, vessels
from tests.enhance.test_real_images import FRAMES, read
from tests.enhance.test_vessel import apart
from tests.enhance.vessel_oracle import without_blotches

OFF = replace(VESSEL, color_smoothing=0.0)
LUMA = np.array([0.299, 0.587, 0.114])


def blotches(image: ByteImage, levels: float, pixels: float = 4.0) -> ByteImage:
    """With noise of Cb and Cr of so many levels and so wide; luma stays."""
    rng = np.random.default_rng(5)
    planes = [cv2.GaussianBlur(rng.normal(0, 1, image.shape[:2]), (0, 0), pixels / 2.5) for _ in range(2)]
    red, blue = (levels * plane / plane.std() for plane in planes)
    noise = np.dstack((1.402 * red, -0.714 * red - 0.344 * blue, 1.772 * blue))
    return np.rint(np.clip(image + noise, 0, 255)).astype(np.uint8)


def apart_in_color(image: ByteImage, wanted: ByteImage) -> float:
    """Deviation of the colours, of blocks of 4 x 4 pixels, beside the highlight."""
    both = [
        cv2.resize(each[:100].astype(np.float32), None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
        for each in (image, wanted)
    ]
    red_to_green, blue_to_green = (
        (both[0] - both[1]) @ np.array(weights) for weights in ((1, -1, 0), (0, -1, 1))
    )
    return float(np.hypot(red_to_green, blue_to_green).mean())


def plain(image: NDArray[np.float32], share: float) -> NDArray[np.float64]:
    """`without_blotches` of floats in double precision, one step after the other."""
    given = image.astype(np.float64)
    below, beside = -image.shape[0] % 4, -image.shape[1] % 4
    whole = np.pad(given, ((0, below), (0, beside), (0, 0)), mode="edge")
    blocks = whole.reshape(whole.shape[0] // 4, 4, -1, 4, 3)[:, 1:3, :, 1:3].mean(axis=(1, 3))
    lit = np.minimum(blocks.max(axis=2, keepdims=True) / (24 / 255), 1)
    taps = np.exp(-(np.arange(-8, 9) ** 2) / (2 * 2.0**2))
    taps /= taps.sum()
    sums = [
        cv2.sepFilter2D(plane, cv2.CV_64F, taps, taps, borderType=cv2.BORDER_REFLECT_101)
        for plane in ((blocks - (blocks @ LUMA)[..., None]) * lit).transpose(2, 0, 1)
    ]
    shares = cv2.sepFilter2D(lit[..., 0], cv2.CV_64F, taps, taps, borderType=cv2.BORDER_REFLECT_101)
    around = np.dstack(sums) / np.maximum(shares, 1e-3)[..., None]
    around = cv2.resize(around, (whole.shape[1], whole.shape[0]))[: image.shape[0], : image.shape[1]]
    smooth = given + share * ((given @ LUMA)[..., None] + around - given)
    return np.asarray(np.clip(smooth, 0, given.max(axis=2, keepdims=True)))


@pytest.mark.parametrize("size", [(96, 120), (97, 301), (33, 530), (4, 4), (1, 1), (3, 40)])
@pytest.mark.parametrize("share", [0.3, 1.0])
def test_the_kernel_agrees_with_the_plain_reading(size: tuple[int, int], share: float) -> None:
    image = np.random.default_rng(0).random((*size, 3)).astype(np.float32)
    image[: size[0] // 3] = 0
    found = without_blotches(image, EVERYWHERE, share)
    np.testing.assert_allclose(found, plain(image, share), atol=2e-6)


def test_outside_the_field_pixels_stay() -> None:
    image, spans = blotches(vessels(), 6), np.full((120, 2), (40, 99), np.int32)
    spans[:30] = 0
    found = without_blotches(image, spans, 1.0)
    changed = (found != image).any(axis=2)
    assert not changed[:30].any()
    assert not changed[:, :40].any()
    assert not changed[:, 99:].any()
    assert changed[30:, 40:99].mean() > 0.7


@settings(max_examples=40, deadline=None)
@given(images())
def test_noise_is_measured_as_the_plain_reading_does(image: NDArray[np.generic]) -> None:
    found, exact = enhance(image).statistics.color_noise, enhance_reference(image)[1].color_noise
    assert found == exact
    assert enhance_vessels(image).statistics.color_noise == found


@pytest.mark.data
@pytest.mark.parametrize("name", FRAMES)
def test_results_of_tissue_keep_their_bytes(name: str) -> None:
    image = read(FRAMES[name])
    assert np.array_equal(enhance_vessels(image).image, enhance_vessels(image, OFF).image)


@pytest.mark.parametrize(("levels", "pixels"), [(3.0, 4.0), (6.0, 4.0), (6.0, 8.0)])
def test_blotches_become_no_freckles(levels: float, pixels: float) -> None:
    clean = vessels(360, 480)
    image, mask = blotches(clean, levels, pixels), vessel_mask(clean)
    assert np.array_equal(enhance_vessels(clean).image, enhance_vessels(clean, OFF).image)
    own, before, wanted = (
        enhance_vessels(*given).image for given in ((image, VESSEL), (image, OFF), (clean, VESSEL))
    )
    freckles = [apart_in_color(each, wanted) for each in (own, before)]
    assert freckles[0] < 0.65 * freckles[1]
    assert vessel_cnr(own, mask) > vessel_cnr(before, mask)


def test_luma_stays_where_nothing_is_cut_off_and_nothing_gets_brighter() -> None:
    image = (0.3 + 0.4 * np.random.default_rng(1).random((64, 80, 3))).astype(np.float32)
    found = without_blotches(image, EVERYWHERE, 1.0)
    assert (found.max(axis=2) <= image.max(axis=2)).all()
    free = (plain(image, 1.0) < image.max(axis=2, keepdims=True) - 1e-4).all(axis=2)
    np.testing.assert_allclose((found @ LUMA)[free], (image @ LUMA)[free], atol=1e-6)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_the_preset_agrees_with_the_plain_reading(dtype: type) -> None:
    for levels in (2, 4, 8):
        image = as_type(blotches(vessels(), levels, 6) / 255, dtype)
        assert coarse_share(enhance_vessels(image).statistics.color_noise) > 0
        assert apart(image, VESSEL).max() <= 1.01


@given(st.floats(0, 1))
def test_the_share_rises_without_a_jump(noise: float) -> None:
    share = coarse_share(noise)
    assert (share == 0) == (noise <= 0.2)
    assert (share == 1) == (noise >= 0.4)
    assert 0 <= coarse_share(noise + 1e-3) - share < 0.01


def test_what_is_not_known_leaves_noise_as_records_of_before_do() -> None:
    image = blotches(vessels(), 6)
    known = measure([image])
    assert known.color_noise is not None
    assert known.color_noise > 0.4
    told = enhance_vessels(image, statistics=replace(known, color_noise=None)).image
    assert np.array_equal(told, enhance_vessels(image, OFF, statistics=known).image)
    assert not np.array_equal(told, enhance_vessels(image, statistics=known).image)
    with pytest.raises(ImageError, match="finite"):
        replace(known, color_noise=float("nan"))


def test_a_clip_has_the_noise_of_its_frames_together_and_a_stream_follows_it() -> None:
    clean, noisy = vessels(), blotches(vessels(), 6)
    alone = [measure([image]).color_noise or 0.0 for image in (clean, noisy)]
    assert min(alone) < (measure([clean, noisy]).color_noise or 0.0) < max(alone)
    enhancer = VesselEnhancer(LiveStatistics(half_life=1))
    enhancer.show(clean)
    first = enhancer.enhance().statistics.color_noise
    enhancer.show(noisy)
    assert first == alone[0]
    assert enhancer.enhance().statistics.color_noise == pytest.approx(sum(alone) / 2)


def test_memory_that_is_used_again_changes_no_result() -> None:
    enhancer = VesselEnhancer()
    for image in (
        blotches(vessels(), 6),
        vessels(),
        blotches(vessels(seed=2), 4),
        blotches(vessels(90, 99), 6),
    ):
        enhancer.show(image)
        for params in (VESSEL, OFF, replace(VESSEL, color_smoothing=0.5), VESSEL):
            assert np.array_equal(enhancer.enhance(params).image, enhance_vessels(image, params).image)


def test_each_image_is_looked_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its noise is known before, or given."""
    looks = []

    def counted(*given: object) -> None:
        looks.append(len(given))
        first_pass(*given)

    monkeypatch.setattr(vessel, "first_pass", counted)
    image = blotches(vessels(), 6)
    for known in (None, measure([image])):
        looks.clear()
        enhance_vessels(image, statistics=known)
        assert len(looks) == 1


def test_what_is_measured_is_measured_of_what_is_enhanced() -> None:
    """Noise of colour makes saturation larger than it is."""
    clean = vessels(360, 480)
    wanted = enhance_vessels(clean).statistics.saturation_mean
    own, before = (
        enhance_vessels(blotches(clean, 12), params).statistics.saturation_mean for params in (VESSEL, OFF)
    )
    assert abs(own - wanted) < 0.8 * (before - wanted)


def test_statistics_that_are_given_and_own_ones_take_turns() -> None:
    image, enhancer = blotches(vessels(), 6), VesselEnhancer()
    known = measure([vessels()])
    enhancer.show(image)
    for params, statistics in ((VESSEL, known), (VESSEL, None), (OFF, known), (OFF, None), (VESSEL, None)):
        result = enhancer.enhance(params, statistics=statistics)
        alone = enhance_vessels(image, params, statistics=statistics)
        assert np.array_equal(result.image, alone.image)
        assert result.statistics == alone.statistics


@pytest.mark.parametrize("side", [4, 8, 16, 32])
def test_what_has_a_colour_is_no_noise(side: int) -> None:
    y, x = np.mgrid[:240, :320] // side
    image = np.where(((x + y) % 2)[..., None], (200, 60, 60), (60, 200, 60)).astype(np.uint8)
    assert coarse_share(enhance_vessels(image).statistics.color_noise) == 0


def test_few_pixels_have_no_noise_by_chance() -> None:
    image = np.random.default_rng(0).integers(0, 256, (240, 320, 3), dtype=np.uint8)
    assert coarse_share(enhance_vessels(image).statistics.color_noise) == 1
    few = np.zeros(image.shape[:2], bool)
    few[100:130, 100:130] = True
    for result in (enhance_vessels(image[:40, :40]), enhance_vessels(image, tissue_mask=few)):
        assert 0 < (result.statistics.color_noise or 0) < 0.15


def test_grey_images_have_none() -> None:
    for image in (vessels()[..., 1], np.repeat(vessels()[..., 1:2], 3, axis=2)):
        result = enhance_vessels(image)
        assert result.statistics.color_noise is None
        assert np.array_equal(result.image, enhance_vessels(image, OFF).image)
