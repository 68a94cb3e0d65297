from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from enhance import ImageError
from enhance.color_difference import vessel_color_difference
from enhance.halos import highlight_halo
from enhance.metrics import (
    blackened_share,
    dvbv_local,
    dvbv_otsu,
    flicker,
    line_scale,
    saturated_share,
    vessel_cnr,
    vessel_contrast,
)
from enhance.noise import chroma_noise_gain, noise_gain
from enhance.ridges import vessel_mask
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


@pytest.mark.parametrize("level", range(60, 250, 3))
def test_a_background_of_one_level_has_no_local_variance(level: int) -> None:
    image = np.full((64, 64, 3), level, np.uint8)
    image[:, 30:34] = 5
    found = dvbv_local(image, image)
    assert found.dv > 100
    assert found.bv == 0
    assert math.isnan(found.ratio)


def test_the_least_step_of_16_bits_has_a_local_variance() -> None:
    image = np.full((64, 64), 60000, np.uint16)
    image[32, 32] += 1
    # Of windows of 25 pixels, one of which is one step of 255 / 65535 grey levels above the others.
    assert dvbv_local(image, image).dv == pytest.approx(24 / 25**2 * (255 / 65535) ** 2, rel=0.05)


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
    for unknown in (-1.0, math.nan, math.inf):
        with pytest.raises(ImageError, match="expected a threshold of 0 or more, got"):
            dvbv_local(spot, spot, threshold=unknown)
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
    with pytest.raises(ImageError, match="expected a mask"):
        vessel_contrast(vessels(20, 30), np.ones((30, 20), bool))


def test_otsu_within_a_mask_is_that_of_the_cut_out() -> None:
    image = vessels(60, 80)
    mask = np.zeros((60, 80), bool)
    mask[10:50, 20:70] = True
    assert dvbv_otsu(image, tissue_mask=mask) == dvbv_otsu(image[10:50, 20:70])
    assert dvbv_otsu(image, tissue_mask=~mask) != dvbv_otsu(image)
    assert math.isnan(dvbv_otsu(image, tissue_mask=np.zeros((60, 80), bool)).dv)
    with pytest.raises(ImageError, match="expected a mask"):
        dvbv_otsu(image, tissue_mask=mask.T)


def drawn() -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """A vessel of green 60 on 100 +- 10, and where it is."""
    image = np.full((60, 60, 3), (200, 100, 80), np.uint8)
    image[::2, :, 1] += 10
    image[1::2, :, 1] -= 10
    mask = np.zeros((60, 60), bool)
    mask[:, 28:32] = True
    image[mask, 1] = 60
    return image, mask


def test_contrast_to_noise_is_the_drop_in_deviations() -> None:
    image, mask = drawn()
    assert vessel_cnr(image, mask) == pytest.approx(4.0)
    image[::2, :28, 1] += 10
    image[1::2, :28, 1] -= 10
    assert vessel_cnr(image, mask) < 4.0
    flat = np.full((60, 60), 90, np.uint8)
    assert math.isnan(vessel_cnr(flat, mask))


def test_ring_lies_within_the_tissue() -> None:
    image, mask = drawn()
    image[:, :28, 1] = 220
    right = np.zeros((60, 60), bool)
    right[:, 28:] = True
    assert vessel_contrast(image, mask, tissue_mask=right) == pytest.approx(0.4)
    assert vessel_contrast(image, mask) > 0.5


def test_blackened_share_counts_vessel_pixels_that_turn_black() -> None:
    image, mask = drawn()
    after = image.copy()
    after[:15, 28:32] = (47, 20, 20)
    after[:, :10] = 0
    assert blackened_share(after, image, mask) == pytest.approx(0.25)
    after[:15, 28:32] = (48, 20, 20)
    assert blackened_share(after, image, mask) == 0
    image[:15, 28:32] = (30, 30, 30)
    after[:15, 28:32] = 0
    assert blackened_share(after, image, mask) == 0
    assert math.isnan(blackened_share(after, image, np.zeros((60, 60), bool)))


def test_flicker_is_what_the_originals_do_not_have() -> None:
    frames = [np.full((4, 4), level, np.uint8) for level in (100, 110, 105)]
    assert flicker(frames, frames) == 0
    shaken = [frame + np.uint8(20 * (index % 2)) for index, frame in enumerate(frames)]
    assert flicker(shaken, frames) == pytest.approx((30 + 25) / 2 - (10 + 5) / 2)
    assert flicker([frames[0]] * 3, frames) == pytest.approx(-7.5)
    assert math.isnan(flicker(frames[:1], frames[:1]))
    with pytest.raises(ImageError, match="as many images as originals, got 3 and 2"):
        flicker(frames, frames[:2])


def test_measures_against_an_original_want_one_size() -> None:
    small, large = vessels(20, 30), vessels(30, 20)
    mask = np.ones((20, 30), bool)
    for measure in (lambda: noise_gain(small, large), lambda: blackened_share(small, large, mask)):
        with pytest.raises(ImageError, match="one size"):
            measure()
    with pytest.raises(ImageError, match="expected a mask"):
        noise_gain(small, small, tissue_mask=mask.T)
    with pytest.raises(ImageError, match="expected a mask"):
        blackened_share(small, small, mask.T)


def test_local_dvbv_within_a_mask_does_not_see_what_lies_outside() -> None:
    rng = np.random.default_rng(8)
    original = rng.integers(60, 120, (40, 50)).astype(np.uint8)
    original[:, 25:] = 90
    image = np.clip(original.astype(int) * 2 - 80, 0, 255).astype(np.uint8)
    mask = np.ones(image.shape, bool)
    mask[:12] = False
    marred, marred_original = image.copy(), original.copy()
    marred[:12], marred_original[:12] = 255, rng.integers(0, 255, (12, 50))
    within = dvbv_local(image, original, tissue_mask=mask)
    unseen = dvbv_local(marred, marred_original, tissue_mask=mask)
    assert (unseen.dv, unseen.bv) == pytest.approx((within.dv, within.bv))
    assert dvbv_local(marred, marred_original).dv != pytest.approx(within.dv, rel=0.05)
    cut = dvbv_local(image[10:], original[10:], tissue_mask=mask[10:])
    assert (cut.dv, cut.bv) == pytest.approx((within.dv, within.bv))
    assert np.isnan(dvbv_local(image, original, tissue_mask=np.zeros_like(mask)).ratio)


def test_what_is_transparent_counts_in_no_measure() -> None:
    """Whatever colours are stored there, and as if a mask left it out."""
    image = vessels()
    alpha = np.full(image.shape[:2], 255, np.uint8)
    alpha[80:] = 0
    dirty = image.copy()
    dirty[80:] = np.random.default_rng(5).integers(0, 256, dirty[80:].shape, np.uint8)
    clean, dirty = (np.dstack((colors, alpha)) for colors in (image, dirty))
    vessel = image[..., 1] < np.quantile(image[..., 1], 0.1)
    seen: list[Callable[[Any], float]] = [
        lambda one: dvbv_otsu(one).ratio,
        saturated_share,
        lambda one: dvbv_local(one, clean).ratio,
        lambda one: vessel_contrast(one, vessel),
        lambda one: vessel_cnr(one, vessel),
        lambda one: vessel_color_difference(one, vessel),
        lambda one: noise_gain(one, clean),
        lambda one: noise_gain(clean, one),
        lambda one: chroma_noise_gain(one, clean),
        lambda one: blackened_share(one, clean, vessel),
        lambda one: flicker([clean, one], [clean, clean]),
    ]
    assert [measure(dirty) for measure in seen] == [measure(clean) for measure in seen]
    assert dvbv_otsu(dirty) == dvbv_otsu(image[:80])
    assert saturated_share(dirty) == saturated_share(image[:80])
    assert math.isnan(saturated_share(np.zeros((4, 4, 4), np.uint8)))


def test_masks_are_read_as_those_of_enhance() -> None:
    """Lists are masks; numbers with a fraction, NaN among them, are none."""
    image = vessels(40, 50)
    mask = image[..., 1] < np.quantile(image[..., 1], 0.2)
    listed: Any = mask.tolist()
    assert vessel_contrast(image, listed, tissue_mask=(~mask).tolist()) == vessel_contrast(image, mask)  # type: ignore[arg-type]
    assert highlight_halo(image, image, tissue_mask=listed) == highlight_halo(image, image, tissue_mask=mask)
    ragged: Any = [[True], [True, False]]
    for wrong in (np.where(mask, np.nan, 0.0), ragged, np.ma.masked_array(mask)):
        for measure in (vessel_contrast, vessel_cnr, lambda one, mask: blackened_share(one, one, mask)):
            with pytest.raises(ImageError, match="expected a mask"):
                measure(image, wrong)


def test_the_saturated_share_is_of_the_pixels_of_the_mask() -> None:
    image = np.full((20, 20), 100, np.uint8)
    image[:5], image[10:] = 255, 0
    mask = np.arange(20)[:, None].repeat(20, axis=1) < 10
    assert (saturated_share(image), saturated_share(image, tissue_mask=mask)) == (0.25, 0.5)
    with pytest.raises(ImageError, match="expected a mask of shape"):
        saturated_share(image, tissue_mask=mask[:4])


def test_a_mask_that_is_no_array_is_refused() -> None:
    nothing: Any = "x"
    with pytest.raises(ImageError, match="expected a mask as an array of numbers, got str of <U1"):
        vessel_cnr(np.zeros((20, 20, 3), np.uint8), nothing)


VESSEL_MEASURES: list[Callable[..., float]] = [vessel_contrast, vessel_cnr, vessel_color_difference]


@pytest.mark.parametrize("measure", VESSEL_MEASURES)
def test_a_file_of_vessels_that_is_not_there_is_no_image_full_of_them(measure: Callable[..., float]) -> None:
    image, unread = np.zeros((20, 20, 3), np.uint8), None  # As OpenCV reads it.
    with pytest.raises(ImageError, match="expected a vessel_mask of shape"):
        measure(image, unread)
    with pytest.raises(ImageError, match="expected a vessel_mask of shape"):
        blackened_share(image, image, unread)  # type: ignore[arg-type]


@pytest.mark.parametrize("scale", [0, -1, math.nan])
@pytest.mark.parametrize("measure", VESSEL_MEASURES)
def test_a_scale_that_makes_no_length_is_refused(measure: Callable[..., float], scale: float) -> None:
    image, vessel = np.zeros((20, 20, 3), np.uint8), np.ones((20, 20), bool)
    with pytest.raises(ImageError, match="expected a scale above 0, got"):
        measure(image, vessel, scale=scale)
    with pytest.raises(ImageError, match="expected a scale above 0, got"):
        vessel_mask(image, scale=scale)


@pytest.mark.parametrize("given", [None, "x.png", np.zeros(5, np.uint8), np.zeros((0, 4), np.uint8)])
def test_the_scale_of_what_is_no_image_is_refused(given: Any) -> None:
    with pytest.raises(ImageError, match="expected an image"):
        line_scale(given)
