from __future__ import annotations

import math
from collections.abc import Callable
from statistics import NormalDist

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from enhance import ImageError, edge_halo, highlight_halo, unsharp
from tests.enhance.pictures import vessels

Halo = Callable[..., float]
HALOS = pytest.mark.parametrize("halo", [highlight_halo, edge_halo])
SIGMA = 3.0
"""Of unsharp, in pixels."""


def step(left: int, right: int, at: int = 128) -> NDArray[np.uint8]:
    image = np.full((96, 256, 3), left, np.uint8)
    image[:, at:] = right
    return image


def beyond(height: float, distance: float) -> float:
    """What unsharp masking adds beside a step, at the middle of a pixel."""
    return height * (1 - NormalDist().cdf(distance / SIGMA))


def scene() -> NDArray[np.uint8]:
    """With a highlight and a fold."""
    image = vessels(192, 256)
    image[:, 200:] //= 3
    return image


@HALOS
def test_the_original_has_none(halo: Halo) -> None:
    assert halo(scene(), scene()) == 0


@HALOS
@given(power=st.floats(0.4, 2.5))
def test_a_curve_of_grey_has_none_however_steep(halo: Halo, power: float) -> None:
    grey = np.repeat(scene()[..., 1:2], 3, axis=2)
    curve = np.rint(255 * (np.arange(256) / 255) ** power).astype(np.uint8)
    assert abs(halo(curve[grey], grey)) < 1e-9


@HALOS
def test_a_curve_of_each_colour_has_nearly_none(halo: Halo) -> None:
    curve = np.rint(255 * np.sqrt(np.arange(256) / 255)).astype(np.uint8)
    assert abs(halo(curve[scene()], scene())) < 0.3
    assert halo(unsharp(scene()), scene()) > 2


def test_beside_a_highlight_it_is_the_undershoot_of_unsharp_masking() -> None:
    image = step(120, 240)
    # Of the pixels at 3 to 10 from the highlight, less what those at 11 to 20 have.
    near, far = (
        np.mean([beyond(120, distance - 0.5) for distance in between])
        for between in (range(3, 11), range(11, 21))
    )
    assert highlight_halo(unsharp(image), image) == pytest.approx(near - far, abs=0.5)


def test_beside_an_edge_it_is_the_mean_of_both_overshoots() -> None:
    image = step(80, 180)
    found = edge_halo(unsharp(image), image)
    halves = [
        np.mean([beyond(100, first + n) for n in range(8)])
        - np.mean([beyond(100, first + n) for n in range(8, 18)])
        for first in (1.5, 3.5)
    ]
    # The edge is a pixel of either side, so one of them begins a pixel farther from the step.
    assert halves[1] < found < halves[0]


def test_more_of_it_is_more_and_a_glow_is_negative() -> None:
    image = step(120, 240)
    once = unsharp(image).astype(np.float64) - image
    found = [highlight_halo(np.rint(image + share * once).astype(np.uint8), image) for share in (0.5, 1.0)]
    assert 0 < found[0] < found[1] < 2.2 * found[0]
    glow = np.rint(image - 0.5 * once * (image < 200)).astype(np.uint8)
    assert highlight_halo(glow, image) < -1


def test_edges_are_strong_and_not_those_of_highlights() -> None:
    for image in (step(80, 110), step(120, 240), step(100, 100)):
        assert math.isnan(edge_halo(unsharp(image), image))
    assert edge_halo(unsharp(step(80, 130)), step(80, 130)) > 1


def test_without_a_highlight_or_anything_to_compare_it_is_not_measured() -> None:
    image = step(120, 240)
    assert math.isnan(highlight_halo(image, step(120, 200)))
    assert math.isnan(highlight_halo(image, image, tissue_mask=np.zeros((96, 256), bool)))


@HALOS
def test_only_the_tissue_counts(halo: Halo) -> None:
    image, spoiled = scene(), unsharp(scene())
    keep = np.ones(image.shape[:2], bool)
    keep[100:] = False
    other = spoiled.copy()
    other[100:] = 0
    assert halo(other, image, tissue_mask=keep) == halo(spoiled, image, tissue_mask=keep)
    assert halo(other, image) != halo(spoiled, image)


@HALOS
def test_what_is_stored_where_alpha_is_0_does_not_count(halo: Halo) -> None:
    """A highlight and edges are stored there, which no mask leaves out."""
    image = scene()
    image[:, 230:] = (0, 0, 0)
    alpha = np.full((*image.shape[:2], 1), 255, np.uint8)
    alpha[160:] = 0
    stored = image.copy()
    stored[160:, ::24] = 255
    results = [unsharp(image), unsharp(image)]
    results[1][160:] = 90
    one, other = (
        halo(np.dstack((result, alpha)), np.dstack((original, alpha)))
        for result, original in zip(results, (image, stored), strict=True)
    )
    assert one == other
    far = np.arange(192)[:, None].repeat(256, axis=1) < (160 if halo is highlight_halo else 160 - 20)
    assert one == pytest.approx(halo(results[0], image, tissue_mask=far), abs=1e-9)
    assert math.isnan(halo(*(np.dstack((each, 0 * alpha)) for each in (results[0], image))))


def test_the_border_of_what_is_visible_is_no_edge() -> None:
    image = np.dstack((step(120, 120), np.full((96, 256), 255, np.uint8)))
    image[:, 200:] = 0
    assert math.isnan(edge_halo(image, image))


@HALOS
def test_mirrored_images_have_the_same(halo: Halo) -> None:
    """Of sizes of whole blocks; Canny's edges may move by a pixel."""
    image, spoiled = scene(), unsharp(scene())
    for mirrored in (np.s_[::-1], np.s_[:, ::-1]):
        assert halo(spoiled[mirrored], image[mirrored]) == pytest.approx(halo(spoiled, image), abs=0.2)


@HALOS
def test_other_sizes_are_refused(halo: Halo) -> None:
    with pytest.raises(ImageError, match="one size"):
        halo(scene()[1:], scene())
    with pytest.raises(ImageError, match="mask of shape"):
        halo(scene(), scene(), tissue_mask=np.ones((3, 4), bool))
