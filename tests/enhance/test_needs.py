from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from enhance import EnhanceParams, Enhancer, enhance, guided_filter, needs
from enhance.guided_filter import WindowModels, window, window_on
from enhance.reference import bilinear, enhance_reference, guided
from tests.enhance.pictures import as_type, images, picture, vessels

DATA = Path(__file__).resolve().parents[2] / "../shared/data"
FRAMES = ("endonerf/pulling_soft_tissues/images/*0000.color.png", "scared/d1k1_rectified_pair/left.png")


@given(st.floats(0, 4), st.floats(0, 8), st.integers(1, 6), st.floats(0, 1))
def test_scale_bound_bounds_what_a_scale_can_do(p: float, reach: float, scales: int, x: float) -> None:
    bound = needs.scale_bound(p, reach, scales)
    for sign in (-1, 1):
        assert 255 * abs(x ** (2 ** (sign * p * reach)) - x) / scales <= bound + 1e-9


@given(st.floats(1e-6, 4), st.floats(1e-3, 8))
def test_scale_bound_is_reached(p: float, reach: float) -> None:
    x = np.linspace(0, 1, 100_001)
    worst = 255 * np.max(x - x ** (2 ** (p * reach)))
    assert needs.scale_bound(p, reach, 1) == pytest.approx(worst, rel=2e-2, abs=1e-3)


def test_scale_bound_at_the_ends() -> None:
    assert needs.scale_bound(0.0, math.inf, 2) == 0
    assert needs.scale_bound(1.0, math.inf, 3) == pytest.approx(85)
    assert needs.scale_bound(1.0, 0.0, 3) == 0


def test_scales_of_least_effect_go_first_until_the_limit() -> None:
    bounds = [needs.scale_bound(1.0, reach, 3) for reach in (0.02, 0.001, 0.004)]
    assert bounds[1] < bounds[2] < bounds[0]
    assert needs.left_out(bounds, bounds[1] * 1.01) == (False, True, False)
    assert needs.left_out(bounds, (bounds[1] + bounds[2]) * 1.01) == (False, True, True)
    assert needs.left_out(bounds, sum(bounds) * 1.01) == (True, True, True)
    assert needs.left_out(bounds, 0.0) == (False, False, False)
    assert needs.left_out((0.0, 255.0), 0.0) == (True, False)


def true_reach(value: NDArray[np.float64], radius: int, params: EnhanceParams) -> float:
    ratio = (guided(value, radius, params) + 1 / 255) / (value + 1 / 255)
    return float(np.abs(np.log2(ratio)).max())


@settings(max_examples=60, deadline=None)
@given(
    images(channels=(0,)),
    st.integers(1, 8),
    st.floats(1e-6, 1),
    st.sampled_from([1, 3, 8, 16, 17, 40, 80]),
)
def test_reaches_are_true_bounds(image: NDArray[Any], subsample: int, eps: float, radius: int) -> None:
    params = EnhanceParams(radii=(radius,), subsample=subsample, eps=eps)
    gray = image.astype(np.float32) / np.float32(np.iinfo(image.dtype).max if image.dtype.kind == "u" else 1)
    enhancer = Enhancer()
    enhancer.show(gray)
    seen = enhancer._surveyed(subsample)
    one = window(radius, eps, subsample)
    models = WindowModels().of(seen.low, (one,), (True,))[one.coarse][0]
    reach = true_reach(gray.astype(np.float64), radius, params)
    local = needs.local_reach(seen.low.fine, one, models)
    assert reach <= local
    assert reach <= needs.range_reach(*seen.range(0.5)) + 1e-6
    assert needs.sparse_reach(seen.low.fine, one, models) <= local


@pytest.mark.parametrize("coarse", [False, True])
def test_local_reach_looks_at_every_model_and_the_blocks_around_it(coarse: bool) -> None:
    """Against one model after another; an extreme block is put anywhere in turn."""
    rng, step = np.random.default_rng(8), 2 if coarse else 1
    models = rng.uniform(0.4, 0.6, (2, 4, 5)).astype(np.float32)
    one = window_on(4, 0.0025, 2, coarse)
    for i, j in np.ndindex(4 * step, 5 * step):
        low = np.stack((np.full((4 * step, 5 * step), 0.5), np.full((4 * step, 5 * step), 1e-4)))
        low[:, i, j] = rng.uniform(0.01, 0.9), 0.002
        expected = 0.0
        for y, x in np.ndindex(4, 5):
            rows, columns = (slice(max(at - 1, 0) * step, (at + 2) * step) for at in (y, x))
            apart = np.sqrt(3 * low[1, rows, columns])  # of four values, so many deviations at most
            for v in (low[0, rows, columns] - apart).min(), (low[0, rows, columns] + apart).max():
                v = min(max(v, 0), 1)
                ratio = (models[0, y, x] * v + models[1, y, x] + 1 / 255) / (v + 1 / 255)
                expected = max(expected, abs(np.log2(ratio)))
        found = needs.local_reach(low.astype(np.float32), one, models)
        assert found == pytest.approx(expected + needs.ROUNDING, rel=1e-5)


@pytest.mark.parametrize("radius", [4, 16])
def test_local_reach_is_nearly_reached_on_tissue(radius: int) -> None:
    """A bound of no use would pass the test above."""
    gray = vessels(128, 160).max(axis=2) / np.float32(255)
    enhancer = Enhancer()
    enhancer.show(gray)
    one = window(radius, 0.0025, 2)
    low = enhancer._surveyed(2).low
    models = WindowModels().of(low, (one,), (True,))[one.coarse][0]
    params = EnhanceParams(radii=(radius,))
    assert needs.local_reach(low.fine, one, models) < 1.6 * true_reach(gray.astype(float), radius, params)


def test_a_scale_that_is_left_out_is_not_filtered(monkeypatch: pytest.MonkeyPatch) -> None:
    scales: list[int] = []
    fit = guided_filter._fit
    monkeypatch.setattr(
        guided_filter, "_fit", lambda *args: scales.extend(sorted(set(args[2][:, 0]))) or fit(*args)
    )
    enhance(vessels(), EnhanceParams(p=(0.5, 0.0, 0.0)))
    assert scales == [0]
    scales.clear()
    enhance(vessels(), EnhanceParams(p=0.0))
    assert scales == []


@settings(max_examples=60, deadline=None)
@given(
    images(),
    st.sampled_from([1e-5, 1e-3, 0.003, 0.01, 0.03]),
    st.sampled_from([1e-6, 1e-5, 0.0025]),
    st.floats(0, 1),
    st.floats(0, 1),
    st.booleans(),
)
def test_error_of_leaving_out_stays_below_its_bound(
    image: NDArray[Any], p: float, eps: float, z: float, limit: float, keep_black: bool
) -> None:
    assume(image.dtype != np.float16)
    params = EnhanceParams(p=p, eps=eps, z=z, omit_below=limit, keep_black=keep_black, radii=(2, 9))
    result = enhance(image, params)
    bound = sum(omission.error for omission in result.omitted)
    assert bound <= limit
    expected, _ = enhance_reference(image, params, statistics=result.statistics)
    full = np.iinfo(image.dtype).max if image.dtype.kind == "u" else 1
    rounding = 127.5 / full if full > 1 else 0
    assert 255 * np.abs(result.image / full - expected).max() <= bound + rounding + 0.015


@pytest.mark.data
@pytest.mark.parametrize("pattern", FRAMES)
@pytest.mark.parametrize("change", [{"p": 0.004}, {"p": 0.01}, {"eps": 1e-6}, {"p": (0.5, 0.0, 0.001)}])
def test_bounds_hold_on_real_images(pattern: str, change: dict[str, Any]) -> None:
    paths = sorted(DATA.glob(pattern))
    if not paths:
        pytest.skip("needs the real data beside the repository")
    read = cv2.imread(str(paths[0]))
    assert read is not None
    image = read[:400, :500].astype(np.float32) / np.float32(255)
    params = EnhanceParams(**change)
    result, full = enhance(image, params), enhance(image, replace(params, omit_below=0.0))
    error = 255 * np.abs(result.image - full.image).max()
    bound = sum(omission.error for omission in result.omitted)
    assert error <= bound + 1e-3
    assert bound < params.omit_below


def test_default_on_tissue_leaves_nothing_out() -> None:
    assert enhance(vessels()).omitted == ()


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"z": 1.0}, {"brightness"}),
        ({"d_factor": 0.0}, {"saturation"}),
        ({"p": 0.0}, {"local detail"}),
        ({"p": (0.5, 0.0, 0.5)}, {"scale of 16 px"}),
        ({"p": 1e-5, "z": 1.0, "d_factor": 0.0}, {"brightness", "local detail", "saturation"}),
        ({"p": 1e-5, "omit_below": 0.0}, set()),
    ],
)
def test_what_is_left_out_is_said(change: dict[str, Any], what: set[str]) -> None:
    omitted = enhance(vessels(), EnhanceParams(**change)).omitted
    assert {omission.what for omission in omitted} == what
    assert all(omission.why and omission.error >= 0 for omission in omitted)


def test_flat_images_need_no_local_detail() -> None:
    flat = as_type(picture("flat", (40, 50, 3), 3), np.uint8)
    assert "local detail" in {omission.what for omission in enhance(flat).omitted}


def test_hidden_pixels_still_count_in_the_bound() -> None:
    """The histogram knows the kept pixels alone; what is hidden is enhanced as well."""
    image = np.full((40, 50, 3), 100, np.uint8)
    image[:, 25:] = vessels(40, 25)
    keep = np.zeros((40, 50), bool)
    keep[:, :10] = True
    assert enhance(image, EnhanceParams(d_factor=1.0), tissue_mask=keep).omitted == ()


def test_bilinear_weights_of_the_bound_are_those_of_the_reference() -> None:
    """A bound over 3 x 3 models needs that no pixel takes more than its own and the next model."""
    for factor in (1, 2, 3, 8):
        for at in range(5):
            spike = np.zeros((5, 5))
            spike[at] = 1
            rows = np.flatnonzero(bilinear(spike, factor)[:, 0]) // factor
            assert rows.min() >= at - 1
            assert rows.max() <= at + 1
