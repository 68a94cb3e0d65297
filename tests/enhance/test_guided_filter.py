from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from enhance import guided_filter
from enhance.chunk import BLOCK
from enhance.reference import bilinear, window_mean
from enhance.survey import survey
from tests.enhance.pictures import KINDS, picture, vessels

Float64 = NDArray[np.float64]


def direct_mean(image: Float64, radius: int) -> Float64:
    """The definition: each window, cut at the border, averaged on its own."""
    out = np.empty_like(image)
    for i, j in np.ndindex(image.shape):
        out[i, j] = image[max(i - radius, 0) : i + radius + 1, max(j - radius, 0) : j + radius + 1].mean()
    return out


def direct_filter(image: Float64, radius: int, eps: float) -> Float64:
    """He, Sun and Tang's filter without subsampling; variances about each window's own mean."""
    a, b = np.empty_like(image), np.empty_like(image)
    for i, j in np.ndindex(image.shape):
        window = image[max(i - radius, 0) : i + radius + 1, max(j - radius, 0) : j + radius + 1]
        a[i, j] = window.var() / (window.var() + eps)
        b[i, j] = (1 - a[i, j]) * window.mean()
    return direct_mean(a, radius) * image + direct_mean(b, radius)


def filtered(value: NDArray[np.float32], radius: int, eps: float, subsample: int) -> NDArray[np.float32]:
    window = (guided_filter.shrunk_radius(radius, subsample), eps, subsample)
    models = guided_filter.WindowModels().of(shrunk(value, subsample), (window,))
    rows, columns = value.shape
    a, b = (bilinear(plane.astype(np.float64), subsample)[:rows, :columns] for plane in models[0])
    return np.asarray(a * value + b, dtype=np.float32)


def shrunk(value: NDArray[np.float32], subsample: int) -> NDArray[np.float32]:
    """What the first pass leaves of a grey image."""
    rows, columns = (-(-size // subsample) for size in value.shape)
    low, blocks = np.empty((rows, columns), np.float32), -(-rows // BLOCK)
    pixels, all_kept = np.repeat(value[..., None], 3, axis=2), np.empty((0, 0), np.uint8)
    survey(
        pixels, all_kept, np.float32(1), subsample, low, np.empty((blocks, 256), np.int64), np.empty(blocks)
    )
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


@settings(max_examples=30, deadline=None)
@given(st.tuples(st.integers(1, 40), st.integers(1, 40)), st.sampled_from([1, 3, 16, 512]))
def test_window_mean_counts_only_what_is_inside(shape: tuple[int, int], radius: int) -> None:
    image = np.random.default_rng(2).random(shape)
    mean = window_mean(image, radius)
    np.testing.assert_allclose(mean, direct_mean(image, radius), atol=1e-12)


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
    twice = direct_mean(direct_mean(image.astype(np.float64), 3), 3)
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


@pytest.mark.parametrize(("shape", "subsample"), [((6, 8), 2), ((7, 9), 2), ((5, 5), 4), ((1, 3), 8)])
def test_shrinking_averages_blocks_and_repeats_the_edge(shape: tuple[int, int], subsample: int) -> None:
    image = np.random.default_rng(5).random(shape)
    rows, columns = (-(-size // subsample) for size in shape)
    expected = np.empty((rows, columns))
    for i, j in np.ndindex(rows, columns):
        at_rows = np.minimum(np.arange(i * subsample, (i + 1) * subsample), shape[0] - 1)
        at_columns = np.minimum(np.arange(j * subsample, (j + 1) * subsample), shape[1] - 1)
        expected[i, j] = image[np.ix_(at_rows, at_columns)].mean()
    np.testing.assert_allclose(shrunk(image.astype(np.float32), subsample), expected, atol=1e-7)


@pytest.mark.parametrize(
    ("radius", "subsample", "expected"), [(4, 2, 2), (64, 2, 32), (5, 2, 3), (1, 2, 1), (1, 8, 1), (3, 1, 3)]
)
def test_radius_shrinks_with_the_image(radius: int, subsample: int, expected: int) -> None:
    assert guided_filter.shrunk_radius(radius, subsample) == expected


def test_strong_edges_stay_and_faint_ones_go() -> None:
    step = np.zeros((40, 40), dtype=np.float32)
    step[:, 20:] = 1
    strong = filtered(step, 4, 0.0025, 1)
    faint = filtered(step * np.float32(0.02), 4, 0.0025, 1)
    assert strong[20, 20] - strong[20, 19] > 0.95
    assert faint[20, 20] - faint[20, 19] < 0.01
