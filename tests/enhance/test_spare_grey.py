"""Of `vessel`: what is grey in red images, as text and metal, keeps its own colour and darkness."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from enhance import enhance_vessels
from enhance.redness import GREY, PALE_IMAGE, RED_IMAGE, TINGED, grey_of
from enhance.vessel import VESSEL, VesselParams
from enhance.vessel_density import Spared, blood_density
from enhance.vessel_first_pass import FLOOR
from tests.enhance.pictures import vessels
from tests.enhance.test_redness import HUES
from tests.enhance.test_vessel import apart, density

WITHOUT = replace(VESSEL, spare_grey=0.0)
PLAIN = VesselParams(shading=0, coring=0)
"""What counts is how dark green is: the same for all lines of `lined`."""
RED, GREY_ONE = 45, 105
"""Columns amid its lines."""


def lined() -> NDArray[np.float64]:
    """Red tissue, with a red line and a grey one that are as dark in green."""
    image = np.full((120, 150, 3), (0.9, 0.6, 0.5))
    image[:, RED - 5 : RED + 5] = 0.7, 0.32, 0.3
    image[:, GREY_ONE - 5 : GREY_ONE + 5] = 0.32, 0.32, 0.32
    # Unevenly lit: what is flat around what is not would count as the surround of fields of view.
    return image * np.linspace(0.9, 1.05, 120)[:, None, None]


def tinged(light: float) -> NDArray[np.float64]:
    """The same, its grey line as red as metal beside tissue is: a logarithm of red over green of 0.12."""
    image = lined()
    image[:, GREY_ONE - 5 : GREY_ONE + 5, 0] *= np.exp(0.12)
    return image * light


def test_a_grey_line_has_less_than_a_tenth_of_the_density_of_a_red_one() -> None:
    spared, all_alike = (density(lined(), replace(PLAIN, spare_grey=k))[60] for k in (1.0, 0.0))
    assert all_alike[GREY_ONE] > 0.6 * all_alike[RED] > 0.1
    assert spared[GREY_ONE] < 0.1 * spared[RED]
    assert spared[RED] == pytest.approx(all_alike[RED], abs=1e-6)


def test_metal_of_a_bluish_tint_is_spared_by_default_too() -> None:
    image = lined()
    image[:, GREY_ONE - 5 : GREY_ONE + 5] *= 0.9, 1.0, 1.05
    spared, all_alike = (density(image, params)[60] for params in (VESSEL, WITHOUT))
    assert all_alike[GREY_ONE] > 0.02
    assert spared[GREY_ONE] < 0.1 * all_alike[GREY_ONE]
    assert spared[RED] == pytest.approx(all_alike[RED], abs=1e-6)


@pytest.mark.parametrize("light", [1.0, 0.2])
def test_kernels_agree_with_the_plain_reading_of_grey_lines(light: float) -> None:
    """Of an underexposed image, too, whose V is brightened before."""
    image = np.rint(255 * light * lined()).astype(np.uint8)
    for params in (VESSEL, replace(PLAIN, contrast=1), replace(PLAIN, contrast=1, spare_grey=0.5)):
        assert apart(image, params).max() <= 1.01
    image = np.rint(255 * tinged(light)).astype(np.uint8)
    for spare_grey in (1.0, 1.5, 2.0):
        assert apart(image, replace(PLAIN, spare_grey=spare_grey)).max() <= 1.01
    assert not np.array_equal(enhance_vessels(image).image, enhance_vessels(image, WITHOUT).image)


def test_a_line_as_red_as_metal_beside_tissue_is_left_out_above_1_alone() -> None:
    found = [density(tinged(1.0), replace(PLAIN, spare_grey=k))[60] for k in (0.0, 1.0, 1.5, 2.0)]
    left = [one[GREY_ONE] / found[0][GREY_ONE] for one in found]
    assert left[1] > 0.6
    assert left[1] - 0.2 > left[2] > left[3] + 0.2
    assert left[3] < 0.15
    for one in found:
        assert one[RED] == pytest.approx(found[0][RED], abs=1e-6)


def test_up_to_1_grey_is_what_it_was_and_in_pale_images_all_the_way() -> None:
    assert grey_of(0.5, 0.0) == grey_of(PALE_IMAGE, 1.0) == GREY
    assert grey_of(RED_IMAGE, 1.0) == grey_of(0.7, 1.0) == pytest.approx(TINGED)
    bounds = np.array([grey_of(redness, 1.0) for redness in np.linspace(0, 1, 1001)])
    steps = np.diff(bounds, axis=0)
    assert 0 <= steps.min() <= steps.max() < 0.003


@pytest.mark.parametrize("bounds", [GREY, TINGED])
def test_it_sets_in_without_a_step_and_never_turns_back(bounds: tuple[float, float]) -> None:
    """Of redness alone, whatever the brightness: none up to the first bound, all from the second on."""
    red = np.linspace(-0.1, 0.35, 451, dtype=np.float32)
    value = np.array([[0.4], [0.7], [1.0], [3.0]], np.float32)
    absorbed = red - np.float32(0.7) * np.log(value + FLOOR)
    planes = absorbed, np.broadcast_to(value, absorbed.shape).copy(), np.full_like(absorbed, -2)
    spared = [Spared(k, bounds) for k in (1.0, 0.5, 0.0)]
    own, half, whole = (blood_density(*planes, 2, 0.0, 0.0, 0.0, 0.3, one) for one in spared)
    low, high = bounds
    kept = np.clip((red.astype(float) - low) / (high - low), 0, 1)
    assert whole.min() > 0.4
    np.testing.assert_allclose(own / whole, np.broadcast_to(kept, own.shape), atol=1e-4)
    np.testing.assert_allclose(half, (own + whole) / 2, rtol=1e-5)
    rise = np.diff(own / whole, axis=1)
    assert rise.min() > -1e-5
    assert rise.max() < 1.1 * 0.001 / (high - low)


GREYS = {
    "one channel": vessels()[..., 1],
    "three channels": np.repeat(vessels()[..., 1:2], 3, axis=2),
}


@pytest.mark.parametrize("name", [*HUES, *GREYS])
def test_images_that_are_grey_or_hardly_red_are_as_without(name: str) -> None:
    """Whatever is reddened there."""
    image: NDArray[Any] = (HUES | GREYS)[name]
    for params in (VESSEL, replace(VESSEL, least_redness=0.0), replace(VESSEL, contrast=1.0)):
        own, without = (enhance_vessels(image, replace(params, spare_grey=k)).image for k in (2.0, 0.0))
        assert np.array_equal(own, without)


def test_more_of_it_never_darkens_more() -> None:
    image = np.rint(255 * tinged(1.0)).astype(np.uint8)
    params = replace(PLAIN, contrast=1, strength=4)
    steps = [
        enhance_vessels(image, replace(params, spare_grey=k)).image for k in (0.0, 0.3, 0.6, 1.0, 1.5, 2.0)
    ]
    for less, more in pairwise(steps):
        assert (more >= less).all()
    assert (steps[-1] > steps[0])[60, GREY_ONE].all()
