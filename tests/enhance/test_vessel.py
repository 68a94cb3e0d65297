from __future__ import annotations

from dataclasses import replace
from typing import Any

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from enhance import EnhanceParams, ImageError, enhance, measure
from enhance.metrics import (
    blackened_share,
    dvbv_otsu,
    saturated_share,
    vessel_cnr,
    vessel_contrast,
)
from enhance.noise import noise_gain
from enhance.ridges import field_of_view, vessel_mask
from enhance.vessel import VESSEL, VesselEnhancer, VesselParams, enhance_vessels
from enhance.vessel_density import BOUND
from enhance.vessel_second_pass import ABSORPTION
from tests.enhance.pictures import DTYPES, as_type, images, vessels
from tests.enhance.test_real_images import DATA, FRAMES, read
from tests.enhance.vessel_oracle import vessels_of

OFF = VesselParams(strength=0)
EXTREMES = (
    VESSEL,
    VesselParams(strength=4, radius=40, shading=1, coring=0, gamma=2, lift=1, d_factor=0.1, most_color=4),
    VesselParams(strength=4, radius=2, shading=0, coring=4, gamma=0.5, lift=0, d_factor=0, most_color=1),
    VesselParams(contrast=1, shading=0),
    VesselParams(contrast=0.5, strength=4, spare_grey=0.5),
)


def density(image: NDArray[np.floating], params: VesselParams) -> NDArray[np.float64]:
    """(H, W) of blood as the result shows it in green, where green was not black; whole from V = 0.4 on."""
    params = replace(params, lift=0, gamma=1, d_factor=0)
    without, found = (
        enhance_vessels(image.astype(np.float32), replace(params, strength=k)).image[..., 1].astype(float)
        for k in (0, 1)
    )
    return np.log(np.divide(without, found, out=np.ones_like(found), where=found > 0))


def apart(image: NDArray[Any], params: VesselParams, **options: Any) -> NDArray[np.float64]:
    """Difference of the kernels to the plain reading, in grey levels."""
    own, plain = (run(image, params, **options).image for run in (enhance_vessels, vessels_of))
    levels = 255 / (np.iinfo(image.dtype).max if image.dtype.kind == "u" else 1)
    return np.asarray(np.abs(own.astype(float) - plain) * levels)


@settings(max_examples=40, deadline=None)
@given(images(), st.sampled_from(EXTREMES))
def test_kernels_agree_with_the_plain_reading(image: NDArray[Any], params: VesselParams) -> None:
    difference = apart(image, params)
    assert difference.max() <= 1.01
    # Where there are but two levels, many pixels may lie at the same tie between two.
    assert difference.mean() < 0.02 or len(np.unique(image)) <= 2


@pytest.mark.data
@pytest.mark.parametrize("name", FRAMES)
def test_kernels_agree_with_the_plain_reading_on_real_frames(name: str) -> None:
    image = read(FRAMES[name])
    tissue = field_of_view(image)
    assert (apart(image, VESSEL, tissue_mask=tissue) > 1).mean() < 1e-4
    assert (apart(image[..., 1], VESSEL, statistics=measure([image])) > 1).mean() < 1e-4


def test_a_stream_gives_what_single_images_give() -> None:
    """Whatever was shown before, and in whichever order the parameters moved."""
    enhancer = VesselEnhancer()
    clip: list[NDArray[Any]] = [vessels(60, 80, 1), vessels(60, 80, 2), vessels(33, 47, 3)[..., 1]]
    clip.append(vessels(60, 80, 4).astype(np.float32) / 255)
    pooled = measure(clip[:2])
    for image in clip:
        enhancer.show(image)
        for params in (*EXTREMES, VESSEL, OFF):
            for statistics in (None, pooled):
                streamed = enhancer.enhance(params, statistics=statistics)
                alone = enhance_vessels(image, params, statistics=statistics)
                assert np.array_equal(streamed.image, alone.image)
                assert streamed.statistics == alone.statistics


def test_a_refused_image_leaves_the_one_before() -> None:
    enhancer = VesselEnhancer()
    with pytest.raises(ImageError, match="shown before"):
        enhancer.enhance()
    enhancer.show(vessels())
    with pytest.raises(ImageError, match="float values"):
        enhancer.show(np.full((4, 4, 3), 3.0))
    assert np.array_equal(enhancer.enhance().image, enhance_vessels(vessels()).image)


def test_results_do_not_depend_on_the_number_of_threads() -> None:
    image, most = vessels(), numba.get_num_threads()
    together = enhance_vessels(image).image
    numba.set_num_threads(1)
    try:
        assert np.array_equal(enhance_vessels(image).image, together)
    finally:
        numba.set_num_threads(most)


@settings(max_examples=30, deadline=None)
@given(images())
def test_shape_type_and_alpha_are_kept(image: NDArray[Any]) -> None:
    result = enhance_vessels(image).image
    assert (result.shape, result.dtype) == (image.shape, image.dtype)
    if image.ndim == 3 and image.shape[2] == 4:
        assert np.array_equal(result[..., 3], image[..., 3])


@pytest.mark.parametrize("dtype", DTYPES)
def test_types_agree(dtype: Any) -> None:
    image = vessels() / 255
    expected = enhance_vessels(image).image
    scale = np.iinfo(dtype).max if np.dtype(dtype).kind == "u" else 1.0
    difference = np.abs(enhance_vessels(as_type(image, dtype)).image / scale - expected)
    assert difference.mean() < 2e-3


def test_more_strength_is_more_contrast_in_proportion_to_absorption() -> None:
    image = vessels() / 255
    plain = enhance_vessels(image, OFF).image
    results = [enhance_vessels(image, VesselParams(strength=k)).image for k in (1.0, 2.0)]
    changed = (plain > 1e-3).all(axis=2) & (results[0] < 0.9 * plain).any(axis=2)
    assert changed.mean() > 0.02
    once, twice = (np.log(plain[changed] / result[changed]) for result in results)
    np.testing.assert_allclose(twice, 2 * once, atol=1e-3)
    np.testing.assert_allclose(once, once[:, 1:2] * ABSORPTION, atol=1e-3)


def test_density_is_of_narrow_structures_in_green_alone() -> None:
    x = np.mgrid[0:120, 0:120][1].astype(np.float32)
    narrow = np.exp(-(((x - 60) / 4) ** 2))[..., None]
    shading = 0.6 + 0.003 * x
    tissue = np.stack([shading, 0.6 * shading, 0.5 * shading], axis=2)
    params = VesselParams(coring=0, shading=1)

    def found(image: NDArray[np.floating]) -> NDArray[np.float64]:
        return density(image, params)[20:100, 20:100]

    full = 0.3 * (ABSORPTION[1] - ABSORPTION[0])
    blood = found(tissue * np.exp(-0.3 * narrow * ABSORPTION))
    assert 0.75 * full < blood[40, 40] < full  # less what the blur, the floor and the bound take
    assert found(tissue).max() < 0.02
    assert found(tissue * (1 - 0.3 * narrow)).max() < 0.02  # a shadow: the same in all channels
    assert found(tissue * np.exp(0.3 * narrow * ABSORPTION))[40, 40] < 0.02


def test_density_hardly_shows_at_a_step_between_tissues() -> None:
    x = np.mgrid[0:120, 0:120][1]
    pale, dense = np.array([0.6, 0.4, 0.3]), np.array([0.42, 0.17, 0.13])
    params = VesselParams(coring=0)
    step = params.shading * np.log(dense[0] / pale[0]) - np.log(dense[1] / pale[1])
    assert density(np.where((x < 60)[..., None], pale, dense), params).max() < 0.2 * step


def test_density_is_bounded() -> None:
    noise = np.random.default_rng(1).random((50, 60, 3))
    reddened = VesselParams(coring=0, least_redness=0, color_smoothing=0)
    strongest = [density(image, reddened).max() for image in (noise, np.round(noise))]
    assert max(strongest) <= BOUND + 1e-6
    assert min(strongest) > 0.8 * BOUND
    for constant in (np.zeros_like(noise), np.ones_like(noise)):
        assert not density(constant, VesselParams(coring=0)).any()


def test_coring_spares_weak_structures() -> None:
    image = np.clip(np.random.default_rng(2).normal(0.5, 0.01, (80, 80, 3)), 0, 1)
    mean = [density(image, VesselParams(coring=k)).mean() for k in (0.0, 1.0, 4.0)]
    assert mean[0] > 1.3 * mean[1] > 1.3 * 1.3 * mean[2]


def test_contrast_darkens_what_is_darker_than_the_median_however_wide() -> None:
    """In proportion to how blood absorbs, so hues of dark areas are those of more blood."""
    tissue = np.full((90, 150, 3), (0.6, 0.4, 0.35))
    tissue[:, :50] *= (1.1, 1.3, 1.3)
    tissue[:, 100:] *= (0.9, 0.5, 0.5)
    params = VesselParams(strength=1, shading=0)
    plain, own = (enhance_vessels(tissue, replace(params, contrast=k)).image for k in (0.0, 1.0))
    assert np.array_equal(plain[:, :96], own[:, :96])
    wide = np.log(plain / own)[:, 106:]
    beyond = np.log((0.4 + 8 / 255) / (0.2 + 8 / 255))
    np.testing.assert_allclose(wide[..., 1], beyond**2 / (beyond**2 + beyond + 0.1), rtol=2e-3)
    np.testing.assert_allclose(wide, wide[..., 1:2] * ABSORPTION, rtol=2e-3)


def test_contrast_grows_with_its_parameter_and_the_strength() -> None:
    image = vessels()
    less, half, full = (enhance_vessels(image, VesselParams(contrast=k)).image for k in (0.0, 0.5, 1.0))
    assert (full <= half).all()
    assert (half <= less).all()
    assert (full < half).mean() > 0.2
    off = replace(OFF, contrast=1)
    assert np.array_equal(enhance_vessels(image, off).image, enhance_vessels(image, OFF).image)


def test_the_median_of_contrast_is_that_of_the_kept_pixels() -> None:
    image = np.full((60, 120, 3), (150, 100, 90), np.uint8)
    image[:, 60:] //= 2
    keep = np.zeros((60, 120), bool)
    keep[:, 80:] = True
    params = VesselParams(contrast=1)
    plain = enhance_vessels(image, tissue_mask=keep).image
    assert np.array_equal(enhance_vessels(image, params, tissue_mask=keep).image, plain)
    assert (enhance_vessels(image, params, tissue_mask=~keep).image[:, 80:] < plain[:, 80:]).any()
    assert (apart(image, params, tissue_mask=~keep) <= 1).all()


def test_noise_of_brightness_is_not_strengthened() -> None:
    noise = np.random.default_rng(3).normal(0, 0.01, (96, 96, 1))
    image = np.array([0.4, 0.25, 0.22]) + noise
    plain = enhance_vessels(image, replace(OFF, lift=0, gamma=1, d_factor=0)).image
    assert noise_gain(plain, image) == pytest.approx(1, abs=0.02)
    assert noise_gain(enhance_vessels(image).image, image) < 1.25


def test_nothing_gets_brighter_by_blood_and_black_stays() -> None:
    image = vessels()
    with_blood, without = (enhance_vessels(image, p).image for p in (VesselParams(), OFF))
    assert np.all(with_blood <= without)
    black = image.copy()
    black[30:80, 40:100] = 0
    assert not enhance_vessels(black).image[40:70, 50:90].any()
    assert saturated_share(enhance_vessels(image).image) <= saturated_share(image)


def test_colours_keep_their_measure() -> None:
    """Grey stays grey; saturation neither falls nor grows beyond its bound, but for rounding."""
    grey = np.repeat(vessels()[..., 1:2], 3, axis=2)
    plain = enhance_vessels(grey, OFF).image
    assert np.ptp(plain, axis=2).max() == 0
    image = np.array([[(0.8, 0.5, 0.4), (0.5, 0.45, 0.3)]]).repeat(20, axis=0).repeat(20, axis=1)
    params = replace(OFF, most_color=1.3, d_factor=0.25)
    before, after = (1 - x.min(axis=2) / x.max(axis=2) for x in (image, enhance_vessels(image, params).image))
    gain = (after / before)[:, np.r_[0:15, 25:40]]
    assert gain.min() > 0.99
    assert gain.max() < 1.31
    assert gain.max() > 1.05


def test_statistics_of_a_clip_and_masks_are_used() -> None:
    clip = [vessels(60, 80, seed) for seed in (1, 2)]
    clip[1] = clip[1] // 2
    pooled = measure(clip)
    results = [enhance_vessels(image, statistics=pooled) for image in clip]
    assert results[0].statistics.z == results[1].statistics.z
    assert results[0].statistics.scope == "clip"
    mask = np.zeros((60, 80), bool)
    mask[20:40, 30:60] = True
    masked, alone = (
        enhance_vessels(clip[0], tissue_mask=mask).statistics,
        enhance_vessels(np.ascontiguousarray(clip[0][20:40, 30:60])).statistics,
    )
    assert masked.z == pytest.approx(alone.z, abs=0.02)
    assert masked.z != enhance_vessels(clip[0]).statistics.z


def test_what_a_mask_leaves_out_does_not_tell_what_is_noise() -> None:
    image = vessels(120, 480)
    mask = np.zeros((120, 480), bool)
    mask[:, :160] = True
    blank = image.copy()
    blank[:, 320:] = 128
    one, other = (enhance_vessels(given, tissue_mask=mask) for given in (image, blank))
    assert one.statistics == other.statistics
    # Openings are in steps of the range of all the image.
    assert (one.image[:, :160] != other.image[:, :160]).mean() < 0.005
    assert (apart(image, VESSEL, tissue_mask=mask) > 1).mean() < 1e-3
    whole = enhance_vessels(image, tissue_mask=np.ones((120, 480), bool)).image
    assert np.array_equal(whole, enhance_vessels(image).image)


def test_bad_images_and_parameters_are_refused() -> None:
    with pytest.raises(ImageError, match="float values"):
        enhance_vessels(np.full((4, 4, 3), 3.0))
    with pytest.raises(ImageError, match="at least one pixel"):
        enhance_vessels(vessels(), tissue_mask=np.zeros((120, 150), bool))
    with pytest.raises(ValueError, match="strength"):
        VesselParams(strength=5)


HELD_OUT = {
    "pulling": ("endonerf/pulling_soft_tissues/images/*0021.color.png", "gt_masks/*0021*", None),
    "scared": ("scared/d1k1_rectified_pair/right.png", None, None),
    "fetoscopy": ("clips/fetoscopy_470x470/input/*00868.png", None, None),
    "retina": ("retina/Image_02L.jpg", None, "retina/Image_02L_1stHO.png"),
}


@pytest.mark.data
@pytest.mark.parametrize("name", HELD_OUT)
def test_held_out_frames_beat_the_papers_method_on_every_bar(name: str) -> None:
    """Frames that the defaults were not tuned on."""
    pattern, tools, truth = HELD_OUT[name]
    image = read(pattern)
    tissue = field_of_view(image)
    if tools is not None:
        (path,) = (DATA / "endonerf/pulling_soft_tissues").glob(tools)
        tissue &= read(str(path.relative_to(DATA)))[..., 0] == 0
        tissue[-16:] = False  # a burned-in status bar
    vessel = vessel_mask(image, tissue_mask=tissue) if truth is None else read(truth)[..., 0] > 0
    paper = enhance(image, EnhanceParams(d_factor=1.0), tissue_mask=tissue).image
    own = enhance_vessels(image, tissue_mask=tissue).image
    ratios = [dvbv_otsu(result, tissue_mask=tissue).ratio for result in (own, paper)]
    assert ratios[0] > ratios[1]
    for contrast in (vessel_contrast, vessel_cnr):
        assert contrast(own, vessel, tissue_mask=tissue) > 1.02 * contrast(paper, vessel, tissue_mask=tissue)
    noise = [noise_gain(result, image, tissue_mask=tissue) for result in (own, paper)]
    assert noise[0] < noise[1]
    assert saturated_share(own) <= saturated_share(paper)
    assert saturated_share(own) <= saturated_share(image)
    assert blackened_share(own, image, vessel) < 1e-3


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_grey_in_three_channels_stays_grey_and_is_as_one_channel(dtype: type) -> None:
    grey = as_type(vessels()[..., 1] / 255, dtype)
    result = enhance_vessels(np.repeat(grey[..., None], 3, axis=2)).image
    assert np.ptp(result.astype(float), axis=2).max() == 0
    single = enhance_vessels(grey).image
    apart = np.abs(result[..., 0].astype(float) - single)
    assert apart.max() <= (1 if dtype == np.uint8 else 257 if dtype == np.uint16 else 2e-3)
