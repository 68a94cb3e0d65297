"""Of `vessel`: no hue is invented where an image is not as red as tissue in white light."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from enhance import ImageError, LiveStatistics, enhance, enhance_vessels, measure, vessel_cnr, vessel_contrast
from enhance.redness import blood_share
from enhance.reference import enhance_reference
from enhance.ridges import field_of_view, vessel_mask
from enhance.vessel import VESSEL, VesselEnhancer, VesselParams
from tests.enhance.pictures import ByteImage, as_type, vessels
from tests.enhance.test_exposure import darker
from tests.enhance.test_real_images import FRAMES, read
from tests.enhance.test_vessel import apart

LEAST = VESSEL.least_redness
ALWAYS = replace(VESSEL, least_redness=0.0)
OFF = replace(VESSEL, strength=0.0)


def tinted(share: float, noise: float = 2.0, seed: int = 3) -> ByteImage:
    """Tissue with a share of its colour, and noise of so many grey levels in each channel."""
    tissue = vessels(180, 240).astype(float)
    grain = np.random.default_rng(seed).normal(0, noise, tissue.shape)
    green = tissue[..., 1:2]
    return np.rint(np.clip(green + share * (tissue - green) + grain, 0, 255)).astype(np.uint8)


def narrow_band() -> ByteImage:
    """Green light in red, blue in the others."""
    return np.rint(vessels(180, 240)[..., [1, 2, 2]] * np.array([0.92, 1, 0.95])).astype(np.uint8)


def fluorescent() -> ByteImage:
    """Vessels are green on grey."""
    grey = np.repeat(vessels(180, 240)[..., 1:2], 3, axis=2)
    vessel = grey[..., 0] < 90
    grey[vessel] = grey[vessel] * np.array([0.5, 1.0, 0.6]) + np.array([0, 90, 10])
    return grey


HUES = {
    "nearly grey": tinted(0.05),
    "noise alone": tinted(0.0, 4.0),
    "narrow band": narrow_band(),
    "fluorescent": fluorescent(),
    "blue": np.ascontiguousarray(vessels(180, 240)[..., ::-1]),
}


def lost(image: NDArray[Any], params: VesselParams) -> NDArray[np.float64]:
    """(n, 3) of the pixels that are clearly darkened, what is left of each channel."""
    image = image.astype(np.float32) / 255
    whole, left = (enhance_vessels(image, one).image for one in (replace(params, strength=0), params))
    clear = (whole > 0.02).all(axis=2) & (left[..., 1] < 0.8 * whole[..., 1])
    assert clear.mean() > 0.005
    return np.asarray(left[clear] / whole[clear], np.float64)


@pytest.mark.parametrize("name", HUES)
@pytest.mark.parametrize("light", [1.0, 0.3])
def test_what_darkens_vessels_leaves_their_hue(name: str, light: float) -> None:
    image = HUES[name] if light == 1 else darker(HUES[name], light, noise=1.0)
    left = lost(image, VESSEL)
    np.testing.assert_allclose(left, left[:, 1:2].repeat(3, axis=1), rtol=1e-5)
    reddened = lost(image, replace(ALWAYS, shading=0.0))
    assert (reddened[:, 0] > 1.1 * reddened[:, 1]).all()


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
def test_overexposed_tissue_is_as_red_as_what_is_not_clipped(kind: type) -> None:
    tissue = vessels(180, 240) / 255
    light = 1 + 3 * np.linspace(1, 0, 180)[:, None, None]
    over = np.clip(light * tissue + 0.05, 0, 1)
    over[:70] = 1
    assert (over[..., 0] - over[..., 1]).sum() < 0.8 * LEAST * over.max(axis=2).sum()
    image = as_type(over, kind)
    redness = enhance(image).statistics.redness
    assert redness is not None
    assert redness > LEAST
    assert np.array_equal(enhance_vessels(image).image, enhance_vessels(image, ALWAYS).image)


def test_fluorescence_that_clips_green_alone_is_not_red() -> None:
    image = fluorescent()
    image[image[..., 1] > image[..., 0] + 40, 1] = 255
    redness = enhance(image).statistics.redness
    assert redness is not None
    assert redness < LEAST / 2


@pytest.mark.parametrize(
    ("tissue", "vessel"), [((180, 180, 180), (160, 160, 160)), ((150, 150, 140), (130, 110, 100))]
)
def test_vessels_stand_out_more_nevertheless(tissue: tuple[int, ...], vessel: tuple[int, ...]) -> None:
    where = np.zeros((96, 96), bool)
    where[:, 46:50] = True
    grain = np.random.default_rng(4).normal(0, 1, (96, 96, 3))
    image = np.rint(np.where(where[..., None], vessel, tissue) + grain).astype(np.uint8)
    own, reddened = (vessel_contrast(enhance_vessels(image, one).image, where) for one in (VESSEL, ALWAYS))
    assert own > 0.9 * reddened
    assert own > 1.8 * vessel_contrast(image, where)


@pytest.mark.parametrize("tint", [(1.0, 1.0, 1.0), (0.96, 1.0, 1.03), (1.0, 1.0, 0.8)])
@pytest.mark.parametrize("noise", [1.0, 3.0])
def test_no_more_noise_is_seen_than_where_vessels_are_reddened(tint: tuple[float, ...], noise: float) -> None:
    grain = np.random.default_rng(5).normal(0, noise, (160, 160, 3))
    image = np.rint(150 * np.array(tint) + grain).astype(np.uint8)
    own, reddened = (enhance_vessels(image, one).image.mean(axis=2).std() for one in (VESSEL, ALWAYS))
    assert own < 1.02 * reddened


@pytest.mark.data
def test_frames_of_the_fetoscope_are_no_noisier_and_their_vessels_as_clear() -> None:
    image = read(FRAMES["fetoscopy"])
    view = field_of_view(image)
    where = vessel_mask(image, tissue_mask=view)
    apart_from_them = view & (cv2.dilate(where.astype(np.uint8), np.ones((9, 9))) == 0)
    found = [enhance_vessels(image, one).image for one in (VESSEL, ALWAYS)]
    for measured in (vessel_contrast, vessel_cnr):
        own, reddened = (measured(one, where, tissue_mask=view) for one in found)
        assert own > reddened
    own, reddened = (_grain(one, apart_from_them) for one in found)
    assert own < 1.03 * reddened


def _grain(image: NDArray[Any], where: NDArray[np.bool_]) -> float:
    """Deviation of what is finer than some six pixels, of the mean."""
    grey = image.astype(np.float32).mean(axis=2)
    fine = grey - cv2.GaussianBlur(grey, (0, 0), 3)
    return float(fine[where].std() / grey[where].mean())


@pytest.mark.parametrize("light", [1.0, 0.15])
def test_nearly_grey_is_much_as_grey_is(light: float) -> None:
    image = darker(tinted(0.0, 0.6), light)
    grey = np.repeat(image.mean(axis=2, keepdims=True).round().astype(np.uint8), 3, axis=2)
    own, alike = (enhance_vessels(one).image.astype(float) for one in (image, grey))
    assert np.abs(own.mean(axis=2) - alike.mean(axis=2)).mean() < 2.5


@pytest.mark.data
@pytest.mark.parametrize("name", FRAMES)
def test_real_frames_of_red_tissue_are_as_they_were(name: str) -> None:
    """Those of the fetoscope are nearly grey."""
    image = read(FRAMES[name])
    own, reddened = (enhance_vessels(image, params) for params in (VESSEL, ALWAYS))
    assert own.statistics.redness is not None
    if name == "fetoscopy":
        assert own.statistics.redness < LEAST / 4
        return
    assert own.statistics.redness > LEAST
    np.testing.assert_array_equal(own.image, reddened.image)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("share", [0.0, 0.05, 0.2, 0.25, 1.0])
def test_kernels_agree_with_the_plain_reading_at_any_redness(share: float, dtype: type) -> None:
    image = as_type(tinted(share) / 255, dtype)
    for given_image in (image, as_type(darker(tinted(share), 0.2) / 255, dtype)):
        for params in (VESSEL, replace(VESSEL, least_redness=0.2, shading=1.0, strength=4.0)):
            difference = apart(given_image, params)
            assert difference.max() <= 1.01
            assert difference.mean() < 0.02


@pytest.mark.parametrize("image", [vessels(), tinted(0.3), narrow_band(), vessels(20, 30)], ids="abcd")
def test_it_is_measured_as_in_the_reference(image: ByteImage) -> None:
    mask = np.zeros(image.shape[:2], bool)
    mask[:, : image.shape[1] // 2] = True
    for kept in (None, mask):
        _, exact = enhance_reference(image, tissue_mask=kept)
        assert exact.redness is not None
        found = enhance(image, tissue_mask=kept).statistics.redness
        assert found == pytest.approx(exact.redness, rel=1e-6, abs=1e-9)
        assert enhance_vessels(image, tissue_mask=kept).statistics.redness == found


def test_what_lies_beyond_the_field_says_nothing_about_it() -> None:
    y, x = np.mgrid[:240, :320]
    inside = np.hypot(x - 160, y - 120) < 100
    image = np.where(inside[..., None], vessels(240, 320), np.array([0, 12, 0])).astype(np.uint8)
    found, alone = enhance_vessels(image).statistics, enhance_vessels(vessels(240, 320)).statistics
    assert found.field is not None
    assert not found.field.is_whole
    assert found.redness == pytest.approx(alone.redness, abs=0.05)


@given(st.floats(-1, 1), st.floats(0.01, 1))
def test_the_share_rises_from_half_of_the_least_to_it(redness: float, least: float) -> None:
    share = blood_share(redness, least)
    assert 0 <= share <= 1
    assert (share == 0) == (redness <= least / 2)
    assert (share == 1) == (redness >= least)
    assert abs(blood_share(redness + 1e-3 * least, least) - share) < 2.1e-3


def test_all_images_are_reddened_where_nothing_is_known_or_nothing_asked() -> None:
    assert blood_share(None, LEAST) == blood_share(-0.3, 0.0) == 1
    grey = tinted(0.0)
    known = measure([grey])
    assert known.redness is not None
    before = enhance_vessels(grey, statistics=replace(known, redness=None)).image
    np.testing.assert_array_equal(before, enhance_vessels(grey, ALWAYS, statistics=known).image)
    assert (before != enhance_vessels(grey, statistics=known).image).any()
    with pytest.raises(ImageError, match="finite"):
        replace(known, redness=float("nan"))


@pytest.mark.parametrize("image", [vessels()[..., 0], np.zeros((40, 40, 3), np.uint8)])
def test_of_what_has_no_colours_none_is_said(image: ByteImage) -> None:
    for found in (enhance(image), enhance_vessels(image)):
        assert found.statistics.redness is None


def test_a_clip_has_that_of_all_its_light_and_grey_images_do_not_count() -> None:
    bright, dark = vessels(180, 240), darker(tinted(0.0), 0.3)
    alone = [measure([image]).redness for image in (bright, dark)]
    assert alone[0] is not None
    assert alone[1] is not None
    weights = [float(image.max(axis=2).mean()) for image in (bright, dark)]
    mean = (alone[0] * weights[0] + alone[1] * weights[1]) / sum(weights)
    assert measure([bright, dark]).redness == pytest.approx(mean, rel=1e-3)
    grey = np.repeat(bright[..., 1:2], 3, axis=2)
    assert measure([bright, grey]).redness == alone[0]


def test_a_stream_follows_it() -> None:
    enhancer, found = VesselEnhancer(LiveStatistics(half_life=1, cut=255)), list[float | None]()
    for image in (vessels(180, 240), *[tinted(0.0, 1.0)] * 2):
        enhancer.show(image)
        found.append(enhancer.enhance().statistics.redness)
    assert found[0] is not None
    assert found[1] == pytest.approx(found[0] / 2, abs=2e-3)
    assert found[2] == pytest.approx(found[0] / 4, abs=2e-3)


def test_nothing_jumps_as_an_image_loses_its_colour() -> None:
    """Of float images, whose results do not round."""
    image = tinted(0.25) / 255
    known = measure([image])
    reds = np.linspace(0.4 * LEAST, 1.1 * LEAST, 71)
    steps = [
        enhance_vessels(image.astype(np.float32), statistics=replace(known, redness=float(red))).image
        for red in reds
    ]
    jumps = 255 * np.abs(np.diff(np.stack(steps), axis=0))
    assert jumps.mean(axis=(1, 2, 3)).max() < 0.3
    assert jumps.max() < 4
    assert 255 * np.abs(steps[0] - steps[-1]).mean() > 1


def test_an_image_is_the_same_as_often_as_parameters_change() -> None:
    enhancer, image = VesselEnhancer(), tinted(0.05)
    enhancer.show(image)
    for least in (LEAST, 0.0, 1.0, LEAST):
        for shading in (0.5, 1.0):
            params = VesselParams(least_redness=least, shading=shading)
            again, anew = enhancer.enhance(params).image, enhance_vessels(image, params).image
            np.testing.assert_array_equal(again, anew)
