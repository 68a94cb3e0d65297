"""What stands where nothing was observed."""

from __future__ import annotations

import numpy as np
import pytest

from app.scenes.backgrounds import BACKGROUNDS, BackgroundName, laid_over
from app.scenes.cpu_rendering import over
from renderer.rasterize.rendered import Rendered, rounded
from renderer.splats import Float32Array
from renderer.unobserved import BLACK, GREY, LINES, line_mask


def half_seen(height: int = 40, width: int = 60) -> tuple[Float32Array, Float32Array]:
    """Reddish tissue on the left, nothing on the right, an edge between."""
    alpha = np.repeat(np.clip((width / 2 + 1.5 - np.arange(width)) / 3, 0, 1)[None], height, axis=0)
    color = np.array([0.8, 0.3, 0.25])
    return (alpha[..., None] * color).astype(np.float32), alpha.astype(np.float32)


@pytest.mark.parametrize("name", BACKGROUNDS)
def test_what_is_seen_is_the_same_over_every_background(name: BackgroundName) -> None:
    image, alpha = half_seen()
    laid = laid_over(image, alpha, BACKGROUNDS[name])
    np.testing.assert_array_equal(laid[alpha == 1], image[alpha == 1])


def test_plain_backgrounds_are_plain() -> None:
    image, alpha = half_seen()
    np.testing.assert_array_equal(laid_over(image, alpha, BLACK), image)
    assert (laid_over(image, alpha, GREY)[alpha == 0] == np.float32(GREY[0])).all()


def test_an_edge_over_grey_goes_from_tissue_to_grey_without_a_darker_fringe() -> None:
    image, alpha = half_seen()
    row = laid_over(image, alpha, GREY)[20]
    assert (np.diff(row[:, 0]) <= 1e-6).all()
    assert row.min() >= GREY[0] - 1e-6


def test_hatching_is_of_two_greys_alone() -> None:
    image, alpha = half_seen(37, 61)
    laid = laid_over(image, alpha, "hatched")
    lines = line_mask(*alpha.shape)
    unseen = alpha == 0
    assert (laid[unseen & lines] == np.float32(LINES[0])).all()
    assert (laid[unseen & ~lines] == np.float32(GREY[0])).all()


def test_a_smooth_background_goes_on_with_the_colours_around_and_is_marked() -> None:
    image, alpha = half_seen()
    laid = laid_over(image, alpha, "smooth")
    lines, unseen = line_mask(*alpha.shape), alpha == 0
    tissue = np.array([0.8, 0.3, 0.25])
    assert np.abs(laid[unseen & ~lines] - tissue).max() <= 1e-5
    assert np.abs(laid[unseen & lines] - tissue).max(axis=1).min() > 0.1


@pytest.mark.parametrize("size", [(1, 1), (1, 17), (17, 1), (2, 3)])
@pytest.mark.parametrize("seen", [0.0, 0.5, 1.0])
def test_a_smooth_background_of_any_size_is_finite(size: tuple[int, int], seen: float) -> None:
    alpha = np.full(size, seen, np.float32)
    laid = laid_over(np.full((*size, 3), 0.5 * seen, np.float32), alpha, "smooth")
    assert laid.shape == (*size, 3)
    assert np.isfinite(laid).all()


@pytest.mark.parametrize("name", BACKGROUNDS)
@pytest.mark.parametrize("size", [(1, 1), (16, 7), (35, 60)])
def test_an_image_laid_over_a_few_rows_at_a_time_is_the_same(
    size: tuple[int, int], name: BackgroundName
) -> None:
    image, alpha = half_seen(*size)
    image += np.random.default_rng(2).normal(0, 0.3, image.shape).astype(np.float32)
    whole = rounded(laid_over(image, alpha, BACKGROUNDS[name]))
    assert np.array_equal(over(Rendered(image, alpha, alpha), BACKGROUNDS[name]), whole)
