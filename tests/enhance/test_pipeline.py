from __future__ import annotations

import weakref
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import permutations
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from enhance import EnhanceParams, enhance, measure, pipeline
from enhance.reference import enhance_reference
from tests.enhance.pictures import DTYPES, as_type, images, picture, vessels

PARAMS = st.builds(
    EnhanceParams,
    strength=st.floats(0, 2),
    z=st.none() | st.floats(0, 1),
    p=st.none() | st.floats(0, 4),
    p_form=st.sampled_from(["literal", "continuous"]),
    radii=st.lists(st.integers(1, 512), min_size=1, max_size=4).map(tuple),
    eps=st.floats(1e-6, 1),
    subsample=st.integers(1, 8),
    d_factor=st.floats(0, 4),
    keep_black=st.booleans(),
    omit_below=st.floats(0, 1),
)


def bytes_of(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.rint(255 * values))


def no_fade(**changes: Any) -> EnhanceParams:
    return EnhanceParams(keep_black=False, **changes)


@settings(max_examples=80, deadline=None)
@given(images(), PARAMS)
def test_any_image_with_any_parameters_gives_one_like_it(image: NDArray[Any], params: EnhanceParams) -> None:
    before = image.copy()
    result = enhance(image, params)
    assert np.array_equal(image, before)
    assert (result.image.shape, result.image.dtype) == (image.shape, image.dtype)
    assert np.isfinite(result.image.astype(np.float64)).all()
    if image.dtype.kind == "f":
        assert result.image.min() >= 0
        assert result.image.max() <= 1
    if image.ndim == 3 and image.shape[2] == 4:
        assert np.array_equal(result.image[..., 3], image[..., 3])
    if params.keep_black:
        black = image == 0 if image.ndim == 2 else np.all(image[..., :3] == 0, axis=2)
        assert not result.image[black][..., :3].any()


@settings(max_examples=60, deadline=None)
@given(images(), PARAMS)
def test_pipeline_agrees_with_the_literal_reading(image: NDArray[Any], params: EnhanceParams) -> None:
    if image.dtype == np.float16:
        image = image.astype(np.float32)
    params = replace(params, omit_below=0.0)
    result = enhance(image, params)
    expected, used = enhance_reference(image, params, statistics=result.statistics)
    full = np.iinfo(image.dtype).max if image.dtype.kind == "u" else 1
    rounding = 0.5 / full if full > 1 else 0
    difference = np.abs(result.image / full - expected) - rounding
    # P = 4 multiplies relative errors of the ratio, and Vn^E by E of up to 256^4, where the result is tiny.
    assert difference.max() < 5e-5
    assert difference.mean() < 1e-6
    own = enhance_reference(image, params)[1]
    # The kernels add up variances: near 0 it is these that are exact, and from 0.1 on the deviations too.
    expected = np.array(own.sigmas if params.p is None else ())
    np.testing.assert_allclose(np.square(used.sigmas), expected**2, rtol=1e-5, atol=4e-4)
    far = expected > 0.1
    np.testing.assert_allclose(np.array(used.sigmas)[far], expected[far], atol=2e-3)
    assert (used.level, used.z) == (own.level, pytest.approx(own.z))
    assert used.saturation_mean == pytest.approx(own.saturation_mean, abs=1e-6)


@pytest.mark.parametrize(
    "params",
    [
        EnhanceParams(),
        no_fade(),
        EnhanceParams(p=1.75, subsample=1),
        EnhanceParams(z=0.0, d_factor=0.5, radii=(4, 16, 64, 256)),
        EnhanceParams(eps=1e-6, p=(0.5, 1.0, 4.0), subsample=8),
    ],
)
def test_bytes_agree_with_the_literal_reading(params: EnhanceParams) -> None:
    image = vessels(200, 260)
    expected = bytes_of(enhance_reference(image, params)[0])
    difference = np.abs(enhance(image, params).image - expected)
    assert difference.max() <= 1
    assert np.mean(difference > 0) <= 1e-4  # measured: at most 1.2e-5 on six real frames


@settings(max_examples=30, deadline=None)
@given(images(channels=(0,)), PARAMS)
def test_grey_stays_grey_bit_for_bit(image: NDArray[Any], params: EnhanceParams) -> None:
    grey = enhance(image, params)
    colored = enhance(np.repeat(image[..., None], 3, axis=2), params)
    assert grey.image.ndim == 2
    for channel in range(3):
        assert np.array_equal(colored.image[..., channel], grey.image)
    assert "saturation" in [omission.what for omission in grey.omitted]


@settings(max_examples=30, deadline=None)
@given(images(channels=(3,)), st.sampled_from(list(permutations(range(3)))), PARAMS)
def test_order_of_colours_does_not_matter(
    image: NDArray[Any], order: tuple[int, ...], params: EnhanceParams
) -> None:
    result = enhance(image[..., order], params)
    straight = enhance(image, params)
    assert np.array_equal(result.image, straight.image[..., order])
    # How red it is, and how noisy, depends on which colour comes first.
    own, other = (replace(each.statistics, redness=None, color_noise=None) for each in (result, straight))
    assert own == other


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(("size", "subsample"), [((64, 96), 1), ((65, 97), 1), ((64, 96), 2), ((64, 96), 8)])
def test_mirrored_in_mirrored_out(axis: int, size: tuple[int, int], subsample: int) -> None:
    image = vessels(*size) / 255
    params = EnhanceParams(subsample=subsample)
    mirrored = np.flip(enhance(np.flip(image, axis), params).image, axis)
    np.testing.assert_allclose(mirrored, enhance(image, params).image, atol=3e-6)


def test_order_of_scales_does_not_matter() -> None:
    image = vessels() / 255
    first = enhance(image, EnhanceParams(radii=(4, 16, 64), p=(0.5, 1.0, 1.75)))
    second = enhance(image, EnhanceParams(radii=(64, 4, 16), p=(1.75, 0.5, 1.0)))
    np.testing.assert_allclose(first.image, second.image, atol=1e-6)


def test_without_saturation_brightness_alone_changes() -> None:
    image = vessels() / 255
    result = enhance(image, EnhanceParams(d_factor=0.0))
    before, after = (x.reshape(-1, 3)[x.max(axis=2).ravel() > 0.1] for x in (image, result.image))
    np.testing.assert_allclose(
        after / after.max(axis=1, keepdims=True), before / before.max(axis=1, keepdims=True), atol=1e-6
    )
    assert [omission.what for omission in result.omitted] == ["saturation"]
    assert enhance(image).omitted == ()


def test_saturation_leaves_brightness_and_hue_alone() -> None:
    image = vessels() / 255
    plain, strong = (enhance(image, EnhanceParams(d_factor=k)).image for k in (0.0, 0.5))
    np.testing.assert_allclose(plain.max(axis=2), strong.max(axis=2), atol=1e-6)
    assert np.array_equal(np.argsort(plain[60, 40:80]), np.argsort(strong[60, 40:80]))
    assert np.abs(plain - strong).max() > 0.05


@pytest.mark.parametrize("keep_black", [True, False])
def test_all_off_is_the_identity(keep_black: bool) -> None:
    image = vessels()
    params = EnhanceParams(z=1.0, p=0.0, d_factor=0.0, keep_black=keep_black)
    assert np.array_equal(enhance(image, params).image, image)


@pytest.mark.parametrize(("level", "expected"), [(0, 51), (1, 83), (50, 131), (128, 132), (255, 255)])
@pytest.mark.parametrize("size", [(1, 1), (1, 9), (2, 2), (50, 50)])
def test_constant_images(level: int, expected: int, size: tuple[int, int]) -> None:
    flat = np.full(size, level, np.uint8)
    result = enhance(flat, no_fade())
    assert np.all(result.image == expected)
    assert result.statistics.level == level
    assert result.statistics.p == (1.75, 1.75, 1.75)
    np.testing.assert_allclose(result.statistics.sigmas, 0, atol=1e-4)


def test_constant_colours() -> None:
    """With S_m = S everywhere, what is mostly coloured loses colour and what is pure stays."""
    skin = enhance(np.full((9, 9, 3), (200, 30, 20), np.uint8), no_fade(z=1.0, d_factor=1.0)).image
    assert np.all(skin == (200, 68, 60))
    red = enhance(np.full((9, 9, 3), (255, 0, 0), np.uint8)).image
    assert np.all(red == (255, 0, 0))


def test_black_surround_stays_black_only_with_keep_black() -> None:
    image = vessels()
    black = ~image.any(axis=2)
    assert not enhance(image, pixels="all").image[black].any()
    assert (enhance(image, no_fade(z=0.0), pixels="all").image[black] > 0).all()


def test_exponent_is_chosen_by_grey_levels() -> None:
    assert enhance(vessels()).statistics.p == (0.5, 0.5, 0.5)
    faint = as_type(0.5 + 0.04 * (picture("noise", (80, 80), 1) - 0.5), np.float32)
    assert set(enhance(faint).statistics.p) == {1.75}


def test_one_p_for_all_scales_is_the_same_p_for_each() -> None:
    image = vessels()
    one, each = enhance(image, EnhanceParams(p=1.2)), enhance(image, EnhanceParams(p=(1.2, 1.2, 1.2)))
    assert np.array_equal(one.image, each.image)


def test_subsampling_changes_little_and_more_with_the_factor() -> None:
    image = vessels(240, 320) / 255
    full = enhance(image, EnhanceParams(subsample=1)).image
    errors = [255 * np.abs(enhance(image, EnhanceParams(subsample=s)).image - full).mean() for s in (2, 4, 8)]
    assert errors == sorted(errors)
    assert errors[0] < 0.25


@pytest.mark.parametrize("dtype", DTYPES)
def test_detail_grows_with_p(dtype: Any) -> None:
    image = as_type(vessels()[..., 1] / 255, dtype)
    spread = []
    for p in (0.0, 0.5, 1.0, 1.75):
        result = enhance(image, EnhanceParams(p=p, z=1.0)).image.astype(np.float64)
        spread.append(np.abs(np.diff(result, axis=1)).mean())
    assert spread == sorted(spread)
    assert spread[-1] > 1.05 * spread[0]


def test_result_can_be_repeated_from_its_statistics() -> None:
    image = vessels()
    first = enhance(image)
    again = enhance(image, statistics=replace(first.statistics))
    assert np.array_equal(first.image, again.image)


@pytest.mark.parametrize("given_values", [{}, {"z": 0.2, "p": 1.5, "d_factor": 0.3}, {"p": (0.5, 1.0, 2.0)}])
def test_more_of_the_strength_changes_more_and_none_of_it_nothing(given_values: dict[str, Any]) -> None:
    image = vessels(120, 160)
    apart = []
    for strength in (0.0, 0.25, 0.5, 1.0, 1.5):
        made = enhance(image, no_fade(strength=strength, **given_values)).image.astype(int)
        apart.append(float(np.abs(made - image).mean()))
    assert apart[0] == 0
    assert apart == sorted(set(apart))


def test_the_strength_of_the_paper_is_one() -> None:
    image = vessels(120, 160)
    assert np.array_equal(enhance(image, EnhanceParams(strength=1.0)).image, enhance(image).image)
    half = enhance(image, EnhanceParams(z=0.4, p=1.0, strength=0.5)).statistics
    assert (half.z, half.p) == (pytest.approx(0.7), (0.5,) * 3)


def test_the_strength_counts_with_the_statistics_of_a_clip() -> None:
    image = vessels(120, 160)
    used = measure([image, image[::-1]])
    params = EnhanceParams(strength=0.5)
    result = enhance(image, params, statistics=used)
    assert result.statistics == used.resolved(params)
    assert 1 - result.statistics.z == pytest.approx((1 - used.z) / 2)


def test_memory_to_work_in_stays_for_the_next_image_and_the_image_does_not() -> None:
    image, large = vessels(90, 120), vessels(1500, 2400)
    expected = enhance(image).image
    kept = pipeline._IDLE.enhancer
    assert kept is not None
    assert 0 < kept.memory <= pipeline.MOST_IDLE
    gone = weakref.ref(image)
    assert np.array_equal(enhance(image).image, expected)
    assert pipeline._IDLE.enhancer is kept
    del image
    assert gone() is None
    enhance(large)
    assert pipeline._IDLE.enhancer is None


def test_each_thread_works_in_memory_of_its_own() -> None:
    images = [vessels(90, 120), vessels(70, 130)]
    expected = [enhance(image).image for image in images]
    own = pipeline._IDLE.enhancer
    with ThreadPoolExecutor(1) as thread:
        found = [thread.submit(enhance, image).result().image for image in images]
        theirs = thread.submit(lambda: pipeline._IDLE.enhancer).result()
    assert own is pipeline._IDLE.enhancer is not theirs is not None
    assert all(np.array_equal(one, other) for one, other in zip(found, expected, strict=True))
