from __future__ import annotations

from typing import Any

import numba
import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from enhance import EnhanceParams, Enhancer, enhance
from enhance.interleave import deinterleave, interleave
from enhance.powers import LEAST_NORMAL, LOG2_ZERO, brief_exp2, brief_log2, exp2, log2
from enhance.reference import enhance_reference
from tests.enhance.pictures import as_type, vessels

Float32 = NDArray[np.float32]


@njit()
def exp2_of(x: Float32, out: Float32) -> None:
    for i in range(len(x)):
        out[i] = exp2(x[i])


@njit()
def log2_of(x: Float32, out: Float32) -> None:
    for i in range(len(x)):
        out[i] = log2(x[i])


@njit()
def brief_powers_of(x: Float32, out: Float32) -> None:
    for i in range(len(x)):
        out[i] = brief_exp2(x[i])


@njit()
def brief_logarithms_of(x: Float32, out: Float32) -> None:
    for i in range(len(x)):
        out[i] = brief_log2(x[i])


@njit()
def apart(pixels: NDArray[Any], planes: NDArray[Any]) -> None:
    deinterleave(pixels, planes)


@njit()
def together(planes: NDArray[Any], pixels: NDArray[Any]) -> None:
    interleave(planes, pixels)


def test_powers_of_two_are_exact_to_float32() -> None:
    x = np.concatenate((np.linspace(-126, 127, 400_001), np.arange(-126, 128))).astype(np.float32)
    out = np.empty_like(x)
    exp2_of(x, out)
    np.testing.assert_allclose(out, np.exp2(x.astype(np.float64)), rtol=2e-7)
    whole = np.arange(-126, 128, dtype=np.float32)
    assert np.array_equal(out[-len(whole) :], np.exp2(whole.astype(np.float64)).astype(np.float32))


def test_brief_powers_are_exact_to_a_thousandth_of_a_grey_level() -> None:
    x = np.linspace(-126, 127, 400_001).astype(np.float32)
    out = np.empty_like(x)
    brief_powers_of(x, out)
    np.testing.assert_allclose(out, np.exp2(x.astype(np.float64)), rtol=3e-6)
    values = np.linspace(1e-6, 2, 400_001).astype(np.float32)
    brief_logarithms_of(values, out)
    np.testing.assert_allclose(out, np.log2(values.astype(np.float64)), rtol=0, atol=3e-6)


def test_very_negative_powers_are_as_good_as_zero() -> None:
    out = np.empty(3, np.float32)
    exp2_of(np.array([-127, -1e6, -1e38], np.float32), out)
    assert np.all(out == LEAST_NORMAL)


def test_logarithms_are_exact_to_float32() -> None:
    x = np.exp2(np.linspace(-126, 20, 400_001)).astype(np.float32)
    x = np.concatenate((x, np.linspace(0.9, 1.1, 100_001, dtype=np.float32)))
    out = np.empty_like(x)
    log2_of(x, out)
    exact = np.log2(x.astype(np.float64))
    assert np.all(np.abs(out - exact) <= 2e-7 * (np.abs(exact) + 1))
    near = np.abs(exact) < 0.1
    np.testing.assert_allclose(out[near], exact[near], rtol=3e-7)


def test_logarithms_of_one_and_of_zero() -> None:
    out = np.empty(3, np.float32)
    log2_of(np.array([1, 0, 1e-39], np.float32), out)
    assert out.tolist() == [0, LOG2_ZERO, LOG2_ZERO]


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
@pytest.mark.parametrize("count", [0, 1, 15, 16, 17, 31, 64, 127])
def test_colours_come_apart_and_together(count: int, dtype: Any) -> None:
    pixels = as_type(np.random.default_rng(count).random((count, 3)), dtype)
    planes = np.full((5, 128), 7, dtype)
    apart(pixels, planes)
    assert np.array_equal(planes[:3, :count], pixels.T)
    assert np.all(planes[:3, count:] == 7)
    assert np.all(planes[3:] == 7)
    again = np.full((count + 20, 3), 9, dtype)
    together(planes, again[:count])
    assert np.array_equal(again[:count], pixels)
    assert np.all(again[count:] == 9)


@pytest.mark.parametrize("columns", [1, 2, 127, 128, 129, 255, 256, 300])
@pytest.mark.parametrize("subsample", [1, 2, 3, 8])
def test_every_width_agrees_with_the_reference(columns: int, subsample: int) -> None:
    image = vessels(37, columns)
    params = EnhanceParams(subsample=subsample, omit_below=0.0)
    result = enhance(image, params)
    expected, _ = enhance_reference(image, params, statistics=result.statistics)
    assert np.abs(result.image - 255 * expected).max() < 0.501


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_number_of_threads_changes_no_bit(dtype: Any) -> None:
    image = as_type(vessels(200, 333) / 255, dtype)
    results = []
    before = numba.get_num_threads()
    try:
        for threads in range(1, before + 1):
            numba.set_num_threads(threads)
            results.append(enhance(image))
    finally:
        numba.set_num_threads(before)
    for other in results[1:]:
        assert np.array_equal(results[0].image, other.image)
        assert results[0].statistics == other.statistics


def test_tables_of_bytes_and_direct_powers_give_the_same_picture() -> None:
    image = vessels(150, 200)
    for params in (EnhanceParams(), EnhanceParams(z=0.0, p=1.3), EnhanceParams(z=1.0, keep_black=False)):
        tables = enhance(image, params).image
        direct = 255 * enhance((image / np.float32(255)).astype(np.float32), params).image.astype(np.float64)
        assert np.abs(tables - direct).max() < 0.5002


@pytest.mark.parametrize("value", [1e-38, 1e-30, 1e-12, 1e-4])
def test_nearly_black_floats_stay_finite(value: float) -> None:
    image = np.zeros((20, 30, 3), np.float32)
    image[5:10, 5:10] = (value, value / 2, 0)
    for params in (EnhanceParams(), EnhanceParams(z=1.0, p=4.0, keep_black=False, eps=1e-6)):
        out = enhance(image, params).image
        assert np.isfinite(out).all()
        assert np.all((out >= 0) & (out <= 1))


def test_a_fresh_enhancer_and_a_used_one_agree_on_every_type() -> None:
    used = Enhancer()
    for dtype in (np.uint8, np.uint16, np.float32):
        for shape in ((60, 70), (20, 300), (60, 70)):
            image = as_type(vessels(*shape) / 255, dtype)
            used.show(image)
            assert np.array_equal(used.enhance().image, enhance(image).image)
