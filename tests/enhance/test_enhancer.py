from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from enhance import EnhanceParams, Enhancer, ImageError, LiveStatistics, enhance, guided_filter, measure
from enhance import enhancer as enhancer_module
from enhance.second_pass import render
from tests.enhance.pictures import DTYPES, as_type, vessels

IMAGE = vessels(90, 140)
CHANGES: list[dict[str, Any]] = [
    {},
    {"z": 0.3},
    {"z": 0.6},
    {"z": 1.0},
    {"p": 1.2},
    {"p": 0.7},
    {"p": 0.5},
    {"p": 0.0},
    {"p": (0.5, 1.0, 0.003)},
    {"p": 1e-5},
    {"d_factor": 0.0},
    {"d_factor": 0.4},
    {"keep_black": False},
    {"radii": (4, 20, 64)},
    {"radii": (4,)},
    {"eps": 1e-4},
    {"eps": 1e-6},
    {"radii": (4, 16, 17)},
    {"radii": (16, 4, 4)},
    {"subsample": 1},
    {"subsample": 2},
    {"subsample": 4},
    {"p_form": "continuous"},
    {"omit_below": 0.0},
]


@settings(max_examples=25, deadline=None)
@given(st.lists(st.sampled_from(CHANGES), min_size=2, max_size=12), st.sampled_from(DTYPES))
def test_any_path_of_the_sliders_ends_where_a_fresh_start_does(
    path: list[dict[str, Any]], dtype: Any
) -> None:
    image = as_type(IMAGE / 255, dtype)
    enhancer = Enhancer()
    enhancer.show(image)
    params = EnhanceParams()
    for change in path:
        radii = change.get("radii", params.radii)
        p = change.get("p", params.p)
        if isinstance(p, tuple) and len(p) != len(radii):
            change = {**change, "p": None}
        params = replace(params, **change)
        moved, fresh = enhancer.enhance(params), enhance(image, params)
        assert np.array_equal(moved.image, fresh.image)
        assert moved.statistics == fresh.statistics
        assert [one.what for one in moved.omitted] == [one.what for one in fresh.omitted]


def test_moved_z_p_and_d_factor_do_not_filter_again(monkeypatch: pytest.MonkeyPatch) -> None:
    enhancer = Enhancer()
    enhancer.show(IMAGE)
    enhancer.enhance()
    fits: list[int] = []
    fit = guided_filter._fit
    monkeypatch.setattr(
        guided_filter, "_fit", lambda *args: fits.append(len(set(args[2][:, 0]))) or fit(*args)
    )
    for change in ({"z": 0.3}, {"p": 1.0}, {"p": 0.9}, {"d_factor": 0.2}, {"keep_black": False}):
        enhancer.enhance(EnhanceParams(**change))  # type: ignore[arg-type]
    assert fits == []
    enhancer.enhance(EnhanceParams(radii=(4, 17, 64)))
    assert fits == [1]
    enhancer.enhance(EnhanceParams(radii=(4, 17, 64), eps=0.01))
    assert fits == [1, 3]


def test_moved_radius_measures_one_scale_and_takes_the_others_as_they_were(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What is left in the planes of the others is used: spoil it, and it shows."""
    enhancer = Enhancer()
    enhancer.show(IMAGE)
    enhancer.enhance()
    measured: list[list[bool]] = []
    monkeypatch.setattr(
        enhancer_module, "render", lambda *args: measured.append(args[9].tolist()) or render(*args)
    )
    for radius in (17, 18):
        moved = enhancer.enhance(EnhanceParams(radii=(4, radius, 64)))
        fresh = enhance(IMAGE, EnhanceParams(radii=(4, radius, 64)))
        assert np.array_equal(moved.image, fresh.image)
        assert moved.statistics == fresh.statistics
    assert measured == [[False, True, False], [True] * 3] * 2
    enhancer.enhance(EnhanceParams())
    assert measured[-1] == [False] * 3
    enhancer._kept[0] = 40
    spoilt, fresh = (one.enhance(EnhanceParams(radii=(4, 19, 64))) for one in (enhancer, shown(IMAGE)))
    assert not np.array_equal(spoilt.image, fresh.image)


def test_moved_eps_takes_the_variances_of_the_windows_as_they_were() -> None:
    """Spoil them, and it shows; another image, width or grid has its own."""
    enhancer = shown(IMAGE)
    for eps in (0.002, 0.001, 1e-6, 0.1):
        moved, fresh = enhancer.enhance(EnhanceParams(eps=eps)), enhance(IMAGE, EnhanceParams(eps=eps))
        assert np.array_equal(moved.image, fresh.image)
    for plane in enhancer._models._kept:
        plane[:] = 0.5
    fine = EnhanceParams(eps=0.01)
    assert not np.array_equal(enhancer.enhance(fine).image, enhance(IMAGE, fine).image)
    for other in (replace(fine, radii=(5, 17, 60)), replace(fine, subsample=1)):
        assert np.array_equal(enhancer.enhance(other).image, enhance(IMAGE, other).image)
    enhancer.show(IMAGE[::-1].copy())
    assert np.array_equal(enhancer.enhance(fine).image, enhance(IMAGE[::-1].copy(), fine).image)


@pytest.mark.parametrize("p", [0.5, 0.7])
@pytest.mark.parametrize("change", [{"radii": (4, 17, 64)}, {"eps": 0.001}, {"subsample": 4}, {"p": 0.6}])
def test_what_is_kept_of_a_scale_is_not_taken_for_another(p: float, change: dict[str, Any]) -> None:
    """With P set nothing is measured, so that only what is kept can tell that a window has moved."""
    enhancer = shown(IMAGE)
    params = EnhanceParams(p=p)
    for z in (0.2, 0.4, 0.6):
        enhancer.enhance(replace(params, z=z))
    moved = replace(params, z=0.6, **change)
    assert np.array_equal(enhancer.enhance(moved).image, enhance(IMAGE, moved).image)


def shown(image: NDArray[Any]) -> Enhancer:
    enhancer = Enhancer()
    enhancer.show(image)
    return enhancer


def test_moved_d_factor_computes_no_detail() -> None:
    """What is left in the plane of V* is used: spoil it, and it shows."""
    enhancer = Enhancer()
    enhancer.show(IMAGE)
    for d_factor in (1.0, 0.9):
        enhancer.enhance(EnhanceParams(d_factor=d_factor))
    enhancer._values[:] = 0
    assert not enhancer.enhance(EnhanceParams(d_factor=0.5, keep_black=False)).image.any()
    assert enhancer.enhance(EnhanceParams(d_factor=0.5, keep_black=False, z=0.2)).image.any()


def test_a_p_beside_one_half_is_that_of_a_fresh_start() -> None:
    """Where only 32 bits make it one half, no logarithm is needed."""
    enhancer = Enhancer()
    enhancer.show(IMAGE)
    for p in (0.7, 0.6, 0.5 + 1e-9, 0.5, 0.8, 0.5 - 1e-9, 0.9, 1.0):
        params = EnhanceParams(p=p)
        got, expected = enhancer.enhance(params).image, enhance(IMAGE, params).image
        assert np.abs(got.astype(int) - expected).max() <= 1, p


def test_results_do_not_share_memory_with_later_ones() -> None:
    enhancer = Enhancer()
    enhancer.show(IMAGE)
    first = enhancer.enhance().image
    before = first.copy()
    enhancer.enhance(EnhanceParams(z=0.0, p=1.75))
    enhancer.show(vessels(90, 140, seed=3) // 3)
    enhancer.enhance()
    assert np.array_equal(first, before)


def test_statistics_of_a_clip_win_and_need_no_measuring() -> None:
    other = vessels(50, 60, seed=2)
    pooled = measure([IMAGE, other])
    enhancer = Enhancer()
    for image in (IMAGE, other):
        enhancer.show(image)
        result = enhancer.enhance(statistics=pooled)
        assert result.statistics == pooled
        assert np.array_equal(result.image, enhance(image, statistics=pooled).image)
        assert not enhancer._moments


def test_bad_images_leave_the_one_before() -> None:
    enhancer = Enhancer()
    with pytest.raises(ImageError, match="to be shown"):
        enhancer.enhance()
    enhancer.show(IMAGE)
    expected = enhancer.enhance().image
    with pytest.raises(ImageError, match="bool"):
        enhancer.show(np.zeros((4, 5), bool))
    assert np.array_equal(enhancer.enhance().image, expected)


def flickering(count: int) -> list[NDArray[np.uint8]]:
    """One scene under a light that jumps up and down."""
    scene = vessels(60, 80).astype(np.float64)
    return [np.rint(scene * (0.75 if index % 2 else 1.0)).astype(np.uint8) for index in range(count)]


def test_live_statistics_begin_with_the_first_image_and_settle() -> None:
    enhancer = Enhancer(LiveStatistics(half_life=2, cut=math.inf))
    dark, bright = vessels(60, 80) // 3, vessels(60, 80)
    enhancer.show(dark)
    first = enhancer.enhance().statistics
    assert first == replace(enhance(dark).statistics, scope="live")
    target = enhance(bright).statistics
    gaps = []
    for _ in range(12):
        enhancer.show(bright)
        gaps.append(abs(enhancer.enhance().statistics.level - target.level))
    assert gaps[1] == pytest.approx(abs(first.level - target.level) / 2)  # two images: one half life
    assert gaps == sorted(gaps, reverse=True)
    assert gaps[-1] < 0.03 * gaps[0]


def test_live_statistics_flicker_less_than_those_of_each_image() -> None:
    live, each = Enhancer(LiveStatistics()), Enhancer()
    changes = {}
    for name, enhancer in (("live", live), ("each", each)):
        z = []
        for image in flickering(12):
            enhancer.show(image)
            z.append(enhancer.enhance().statistics.z)
        changes[name] = np.abs(np.diff(z)).mean()
    assert changes["each"] > 0.05
    assert changes["live"] < 0.2 * changes["each"]


def test_sliders_do_not_move_a_live_stream() -> None:
    enhancer = Enhancer(LiveStatistics(half_life=4))
    for image in flickering(3):
        enhancer.show(image)
        once = enhancer.enhance().statistics
        for z in (0.1, 0.9):
            enhancer.enhance(EnhanceParams(z=z))
        assert enhancer.enhance().statistics == once


@pytest.mark.parametrize("half_life", [-1.0, float("nan"), float("inf")])
def test_a_bad_half_life_is_refused(half_life: float) -> None:
    with pytest.raises(ValueError, match="half_life"):
        LiveStatistics(half_life=half_life)


def test_half_life_zero_follows_at_once() -> None:
    enhancer = Enhancer(LiveStatistics(half_life=0))
    for image in flickering(3):
        enhancer.show(image)
        assert enhancer.enhance().statistics == replace(enhance(image).statistics, scope="live")
