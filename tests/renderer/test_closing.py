"""Small gaps in a view are closed and its edges made even: the kernel against the formula in float64."""

from __future__ import annotations

import numpy as np
import pytest

from renderer.camera import Camera, FloatArray
from renderer.closing import GONE, WHOLE, closed, closing_radius
from renderer.rasterize.rendered import Rendered

COLOR = (0.8, 0.4, 0.2)


def view_of(alpha: FloatArray) -> Rendered:
    """Of one colour, and of depth 5."""
    image = alpha[..., None] * np.array(COLOR)
    return Rendered(image.astype(np.float32), alpha.astype(np.float32), np.full(alpha.shape, 5, np.float32))


def literal(drawn: Rendered, radius: int) -> tuple[FloatArray, FloatArray]:
    """Image and alpha, pixel by pixel."""
    seen, left = drawn.image.astype(np.float64), drawn.alpha.astype(np.float64)
    image, alpha = np.zeros_like(seen), np.zeros_like(left)
    for y, x in np.ndindex(left.shape):
        window = slice(max(y - radius, 0), y + radius + 1), slice(max(x - radius, 0), x + radius + 1)
        share, around = left[window].mean(), seen[window].mean(axis=(0, 1))
        if share > GONE:
            t = min((share - GONE) / (WHOLE - GONE), 1)
            alpha[y, x] = t * t * (3 - 2 * t)
            image[y, x] = alpha[y, x] * (seen[y, x] + (1 - left[y, x]) * around / share)
    return image, alpha


@pytest.mark.parametrize("shape", [(1, 1), (20, 9), (70, 133), (130, 258), (3, 300)])
@pytest.mark.parametrize("radius", [1, 6, 40])
def test_it_is_the_formula(shape: tuple[int, int], radius: int) -> None:
    random = np.random.default_rng(3)
    alpha = random.random(shape) * (random.random(shape) > 0.3)
    alpha[: shape[0] // 3, shape[1] // 2 :] = 0
    image = (random.random((*shape, 3)) * alpha[..., None]).astype(np.float32)
    drawn = Rendered(image, alpha.astype(np.float32), alpha.astype(np.float32))
    found, (expected, expected_alpha) = closed(drawn, radius), literal(drawn, radius)
    assert np.abs(found.image - expected).max() < 2e-5
    assert np.abs(found.alpha - expected_alpha).max() < 2e-5


def test_pinholes_are_closed_in_the_colour_around_and_wide_gaps_are_not() -> None:
    alpha = np.ones((60, 80))
    alpha[20:24, 20:24] = 0
    alpha[30:60, 40:80] = 0
    found = closed(view_of(alpha), 6)
    assert np.allclose(found.image[10:30, 10:30], COLOR, atol=1e-5)
    assert (found.alpha[10:30, 10:30] == 1).all()
    assert (found.alpha[40:, 50:] == 0).all()
    assert (found.image[40:, 50:] == 0).all()


def test_needles_go_and_a_straight_edge_stays_where_it_is() -> None:
    alpha = np.zeros((60, 80))
    alpha[:30] = 1
    alpha[30:45, 40:42] = 1
    found = closed(view_of(alpha), 6)
    assert (found.alpha[37:, :] == 0).all()
    assert (found.alpha[:27] == 1).all()
    assert found.alpha[29, 10] > 0.5 > found.alpha[30, 10]


def test_what_shows_through_tissue_has_its_colour() -> None:
    found = closed(view_of(np.full((40, 40), 0.8)), 3)
    assert np.allclose(found.image, COLOR, atol=1e-5)
    assert (found.alpha == 1).all()


def test_depth_stays_and_without_a_radius_all_does() -> None:
    drawn = view_of(np.full((20, 20), 0.6))
    assert closed(drawn, 4).depth is drawn.depth
    assert closed(drawn, 0) is drawn
    with pytest.raises(ValueError, match="at least 0 pixels, got -1"):
        closed(drawn, -1)


def test_the_window_grows_with_the_view() -> None:
    own = Camera.from_fov(60, 640, 512)
    assert closing_radius(own, own) == pytest.approx(6.4)
    assert closing_radius(own, own.resized(1280, 1024)) == pytest.approx(12.8)
    assert closing_radius(own, own.fitted(2000, 512)) == pytest.approx(6.4)
