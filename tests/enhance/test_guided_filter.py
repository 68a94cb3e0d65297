from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from enhance.field import EVERYWHERE
from enhance.first_pass import first_pass
from enhance.guided_filter import SPAN, Grids, WindowModels, window, window_on
from enhance.pixel_block import BLOCK
from enhance.reference import bilinear, block_means, window_mean
from tests.enhance.pictures import KINDS, picture, vessels

Float64 = NDArray[np.float64]


def direct_mean(image: Float64, reach: float) -> Float64:
    """The definition: each window, cut at the border, averaged on its own, outer pixels in part."""
    whole, part = int(reach), reach % 1
    out = np.empty_like(image)
    for i, j in np.ndindex(image.shape):
        total = weight = 0.0
        for k, m in np.ndindex(image.shape):
            apart = max(abs(i - k), 0), max(abs(j - m), 0)
            share = np.prod([1.0 if one <= whole else part if one == whole + 1 else 0.0 for one in apart])
            total, weight = total + share * image[k, m], weight + share
        out[i, j] = total / weight
    return out


def direct_filter(image: Float64, radius: int, eps: float) -> Float64:
    """He, Sun and Tang's filter without subsampling; variances about each window's own mean."""
    a, b = np.empty_like(image), np.empty_like(image)
    for i, j in np.ndindex(image.shape):
        window = image[max(i - radius, 0) : i + radius + 1, max(j - radius, 0) : j + radius + 1]
        a[i, j] = window.var() / (window.var() + eps)
        b[i, j] = (1 - a[i, j]) * window.mean()
    return boxes(a, radius) * image + boxes(b, radius)


def boxes(image: Float64, radius: int) -> Float64:
    """`direct_mean` of whole pixels, less slowly."""
    out = np.empty_like(image)
    for i, j in np.ndindex(image.shape):
        out[i, j] = image[max(i - radius, 0) : i + radius + 1, max(j - radius, 0) : j + radius + 1].mean()
    return out


def filtered(value: NDArray[np.float32], radius: int, eps: float, subsample: int) -> NDArray[np.float32]:
    one = window(radius, eps, subsample)
    models = WindowModels().of(shrunk(value, subsample), (one,), (True,))
    rows, columns = value.shape
    planes, grid = (models.coarse[0], 2 * subsample) if one.coarse else (models.fine[0], subsample)
    a, b = (bilinear(plane.astype(np.float64), grid)[:rows, :columns] for plane in planes)
    return np.asarray(a * value + b, dtype=np.float32)


def shrunk(value: NDArray[Any], subsample: int) -> Grids:
    """What the first pass leaves of a grey image."""
    rows, columns = (-(-size // subsample) for size in value.shape)
    half = (-(-rows // 2), -(-columns // 2)) if subsample > 1 else (0, 0)
    low = Grids(*(np.empty((2, *size), np.float32) for size in ((rows, columns), half)))
    blocks = -(-rows // BLOCK)
    pixels, all_kept = np.repeat(value[..., None], 3, axis=2), np.empty((0, 0), np.uint8)
    full = np.float32(1 if value.dtype == np.float32 else 255)
    tallies = np.empty((blocks, 256), np.int64), np.empty(blocks), 1, np.empty((3, 0, 0))
    first_pass(pixels, all_kept, EVERYWHERE, full, subsample, *low, *tallies, np.empty(256, np.int64))
    return low


@settings(max_examples=30, deadline=None)
@given(
    st.sampled_from(KINDS),
    st.tuples(st.integers(1, 14), st.integers(1, 17)),
    st.sampled_from([1, 2, 5, 40]),
    st.sampled_from([1e-6, 0.0025, 1.0]),
)
def test_filter_agrees_with_the_definition(
    kind: str, shape: tuple[int, int], radius: int, eps: float
) -> None:
    image = picture(kind, shape, 3).astype(np.float32)
    expected = direct_filter(image.astype(np.float64), radius, eps)
    np.testing.assert_allclose(filtered(image, radius, eps, 1), expected, atol=2e-5 if eps < 1e-4 else 1e-6)


@settings(max_examples=20, deadline=None)
@given(
    st.tuples(st.integers(1, 9), st.integers(1, 9)),
    st.sampled_from([0.0, 0.25, 1.0, 1.75, 2.5, 7.125, 511.5]),
)
def test_window_mean_counts_only_what_is_inside(shape: tuple[int, int], reach: float) -> None:
    image = np.random.default_rng(2).random(shape)
    np.testing.assert_allclose(window_mean(image, reach), direct_mean(image, reach), atol=1e-12)


@pytest.mark.parametrize("subsample", [1, 2, 3, 8])
@pytest.mark.parametrize("shape", [(1, 1), (1, 23), (31, 1), (33, 46)])
def test_flat_stays_flat_and_values_stay_in_range(shape: tuple[int, int], subsample: int) -> None:
    flat = np.full(shape, 0.3, dtype=np.float32)
    np.testing.assert_allclose(filtered(flat, 16, 0.0025, subsample), flat, atol=1e-6)
    noise = np.random.default_rng(4).integers(0, 2, shape).astype(np.float32)
    out = filtered(noise, 4, 0.0025, subsample)
    assert out.shape == shape
    assert out.min() >= 0
    assert out.max() <= 1 + 1e-6


def test_eps_goes_from_the_image_itself_to_its_mean_of_means() -> None:
    image = vessels(40, 50)[..., 1].astype(np.float32) / np.float32(255)
    twice = boxes(boxes(image.astype(np.float64), 3), 3)
    errors = [np.abs(filtered(image, 3, eps, 1) - image).mean() for eps in (1e-6, 1e-4, 1e-2, 1.0)]
    assert errors == sorted(errors)
    assert errors[0] < 3e-4
    np.testing.assert_allclose(filtered(image, 3, 1e6, 1), twice, atol=1e-5)


def test_subsampling_converges_to_the_full_filter() -> None:
    image = vessels(96, 128)[..., 1].astype(np.float32) / np.float32(255)
    full = filtered(image, 16, 0.0025, 1)
    errors = [255 * np.sqrt(np.mean((filtered(image, 16, 0.0025, s) - full) ** 2)) for s in (2, 4, 8)]
    assert errors == sorted(errors)
    assert errors[0] < 1.0


def moments(value: Float64, size: int) -> Float64:
    """(2, h, w) mean and variance of each block, one at a time; the last row and column are repeated."""
    rows, columns = (-(-length // size) for length in value.shape)
    out = np.empty((2, rows, columns))
    for i, j in np.ndindex(rows, columns):
        at_rows = np.minimum(np.arange(i * size, (i + 1) * size), value.shape[0] - 1)
        at_columns = np.minimum(np.arange(j * size, (j + 1) * size), value.shape[1] - 1)
        block = value[np.ix_(at_rows, at_columns)]
        out[:, i, j] = block.mean(), block.var()
    return out


@pytest.mark.parametrize(
    ("shape", "subsample"),
    [((6, 8), 2), ((7, 9), 2), ((5, 5), 4), ((1, 3), 8), ((70, 300), 2), ((11, 13), 3), ((4, 5), 1)],
)
def test_first_pass_leaves_mean_and_variance_of_every_block(shape: tuple[int, int], subsample: int) -> None:
    image = np.random.default_rng(5).random(shape).astype(np.float32)
    low, expected = shrunk(image, subsample), moments(image.astype(np.float64), subsample)
    np.testing.assert_allclose(low.fine, expected, atol=1e-7)
    if subsample > 1:
        coarse = moments(expected[0], 2)
        coarse[1] += moments(expected[1], 2)[0]
        np.testing.assert_allclose(low.coarse, coarse, atol=1e-7)
    else:
        assert low.coarse.size == 0


@pytest.mark.parametrize("spread", [1e-5, 1e-3])
def test_small_variances_of_bright_blocks_are_exact_to_float32(spread: float) -> None:
    noise = np.random.default_rng(6).normal(0, spread, (64, 96))
    image = (0.98 + noise).astype(np.float32)
    for subsample in (2, 3, 8):
        fine = shrunk(image, subsample).fine[1]
        np.testing.assert_allclose(fine, moments(image.astype(np.float64), subsample)[1], rtol=1e-5)


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
@pytest.mark.parametrize(("subsample", "coarse"), [(1, False), (2, False), (2, True), (4, True), (8, False)])
def test_a_window_on_a_grid_has_the_variance_that_the_image_has_in_it(
    dtype: Any, subsample: int, coarse: bool
) -> None:
    """One that sees all of the image: there a is var / (var + eps), however coarse the grid."""
    value = (255 * picture("noise", (64, 96), 3)).astype(np.uint8)
    image = value if dtype == np.uint8 else (value / np.float32(255)).astype(np.float32)
    one = window_on(500, 0.05, subsample, coarse)
    models = WindowModels().of(shrunk(image, subsample), (one,), (True,))
    variance = (value / 255).var()
    slope = variance / (variance + 0.05)
    np.testing.assert_allclose(models[coarse][0, 0], slope, atol=1e-6)
    np.testing.assert_allclose(models[coarse][0, 1], (1 - slope) * (value / 255).mean(), atol=1e-6)


@settings(max_examples=20, deadline=None)
@given(st.tuples(st.integers(1, 40), st.integers(1, 50)), st.integers(1, 60), st.sampled_from([2, 3, 4]))
def test_models_are_those_of_the_literal_windows(shape: tuple[int, int], radius: int, subsample: int) -> None:
    value = picture("vessels", shape, 4).astype(np.float32)
    for coarse in (False, True):
        one, size = window_on(radius, 1e-3, subsample, coarse), (2 if coarse else 1) * subsample
        models = WindowModels().of(shrunk(value, subsample), (one,), (True,))[coarse][0]
        mean, square = (block_means(v, subsample) for v in (value.astype(float), value.astype(float) ** 2))
        if coarse:
            mean, square = block_means(mean, 2), block_means(square, 2)
        reach = max((2 * radius + 1) / size - 1, 0) / 2
        around = window_mean(mean, reach)
        variance = window_mean(square, reach) - around**2
        slope = variance / (variance + 1e-3)
        np.testing.assert_allclose(models[0], window_mean(slope, reach), atol=2e-6)
        np.testing.assert_allclose(models[1], window_mean((1 - slope) * around, reach), atol=2e-6)


@given(st.integers(1, 512), st.integers(1, 8))
def test_a_window_is_as_wide_as_its_radius_asks_and_no_grid_is_too_coarse_for_it(
    radius: int, subsample: int
) -> None:
    one = window(radius, 0.0025, subsample)
    grid = 2 * subsample if one.coarse else subsample
    width = 2 * (one.whole + one.part) + 1
    assert 0 <= one.part < 1
    assert width == pytest.approx(max((2 * radius + 1) / grid, 1))
    assert one.coarse == (subsample > 1 and (2 * radius + 1) / (2 * subsample) >= SPAN)


def test_only_the_scales_that_are_needed_and_new_are_computed() -> None:
    low = shrunk(vessels(40, 60)[..., 0].copy(), 2)
    windows = tuple(window(radius, 0.0025, 2) for radius in (4, 6, 20))
    models = WindowModels()
    expected = [plane.copy() for plane in models.of(low, windows, (True,) * 3)]
    for plane in models.of(low, windows, (False,) * 3):
        plane[:] = 7
    again = models.of(low, windows, (True,) * 3)
    assert np.all(again.fine == 7)
    models.forget()
    models.of(low, windows, (True, False, True))
    assert np.array_equal(again.fine[0], expected[0][0])
    assert np.all(again.fine[1] == 7)
    assert np.array_equal(again.coarse[2], expected[1][2])


def test_strong_edges_stay_and_faint_ones_go() -> None:
    step = np.zeros((40, 40), dtype=np.float32)
    step[:, 20:] = 1
    strong = filtered(step, 4, 0.0025, 1)
    faint = filtered(step * np.float32(0.02), 4, 0.0025, 1)
    assert strong[20, 20] - strong[20, 19] > 0.95
    assert faint[20, 20] - faint[20, 19] < 0.01
