from __future__ import annotations

import math

import numpy as np
import pytest

from enhance import vessel_color_difference
from enhance.color_difference import ciede2000
from tests.enhance.pictures import vessels

PUBLISHED = (
    ((50, 2.6772, -79.7751), (50, 0, -82.7485), 2.0425),
    ((50, 3.1571, -77.2803), (50, 0, -82.7485), 2.8615),
    ((50, 2.8361, -74.0200), (50, 0, -82.7485), 3.4412),
    ((50, -1.3802, -84.2814), (50, 0, -82.7485), 1.0000),
    ((50, -1.1848, -84.8006), (50, 0, -82.7485), 1.0000),
    ((50, -0.9009, -85.5211), (50, 0, -82.7485), 1.0000),
    ((50, 0, 0), (50, -1, 2), 2.3669),
    ((50, -1, 2), (50, 0, 0), 2.3669),
    ((50, 2.49, -0.001), (50, -2.49, 0.0009), 7.1792),
    ((50, 2.49, -0.001), (50, -2.49, 0.0010), 7.1792),
    ((50, 2.49, -0.001), (50, -2.49, 0.0011), 7.2195),
    ((50, 2.49, -0.001), (50, -2.49, 0.0012), 7.2195),
    ((50, -0.001, 2.49), (50, 0.0009, -2.49), 4.8045),
    ((50, -0.001, 2.49), (50, 0.0010, -2.49), 4.8045),
    ((50, -0.001, 2.49), (50, 0.0011, -2.49), 4.7461),
    ((50, 2.5, 0), (50, 0, -2.5), 4.3065),
    ((50, 2.5, 0), (73, 25, -18), 27.1492),
    ((50, 2.5, 0), (61, -5, 29), 22.8977),
    ((50, 2.5, 0), (56, -27, -3), 31.9030),
    ((50, 2.5, 0), (58, 24, 15), 19.4535),
    ((50, 2.5, 0), (50, 3.1736, 0.5854), 1.0000),
    ((50, 2.5, 0), (50, 3.2972, 0), 1.0000),
    ((50, 2.5, 0), (50, 1.8634, 0.5757), 1.0000),
    ((50, 2.5, 0), (50, 3.2592, 0.3350), 1.0000),
    ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
    ((63.0109, -31.0961, -5.8663), (62.8187, -29.7946, -4.0864), 1.2630),
    ((61.2901, 3.7196, -5.3901), (61.4292, 2.2480, -4.9620), 1.8731),
    ((35.0831, -44.1164, 3.7933), (35.0232, -40.0716, 1.5901), 1.8645),
    ((22.7233, 20.0904, -46.6940), (23.0331, 14.9730, -42.5619), 2.0373),
    ((36.4612, 47.8580, 18.3852), (36.2715, 50.5065, 21.2231), 1.4146),
    ((90.8027, -2.0831, 1.4410), (91.1528, -1.6435, 0.0447), 1.4441),
    ((90.9257, -0.5406, -0.9208), (88.6381, -0.8985, -0.7239), 1.5381),
    ((6.7747, -0.2908, -2.4247), (5.8714, -0.0985, -2.2286), 0.6377),
    ((2.0776, 0.0795, -1.1350), (0.9033, -0.0636, -0.5514), 0.9082),
)
"""Of Sharma, Wu and Dalal, Color Research and Application 30(1), 2005, Table 1."""


@pytest.mark.parametrize(("one", "other", "expected"), PUBLISHED)
def test_published_differences(one: tuple[float, ...], other: tuple[float, ...], expected: float) -> None:
    assert ciede2000(np.array(one), np.array(other)) == pytest.approx(expected, abs=6e-5)
    assert ciede2000(np.array(other), np.array(one)) == pytest.approx(expected, abs=6e-5)


def test_it_is_nothing_between_equals_and_the_same_both_ways() -> None:
    rng = np.random.default_rng(0)
    one, other = (rng.uniform((0, -90, -90), (100, 90, 90), (500, 3)) for _ in range(2))
    assert np.all(ciede2000(one, one) == 0)
    assert np.allclose(ciede2000(one, other), ciede2000(other, one))


def striped() -> tuple[np.ndarray, np.ndarray]:
    image, vessel = np.full((128, 192, 3), (200, 130, 120), np.uint8), np.zeros((128, 192), bool)
    vessel[:, 30:34] = vessel[:, 150:154] = True
    return image, vessel


def test_vessels_that_cannot_be_seen_differ_by_nothing_and_redder_ones_by_more() -> None:
    image, vessel = striped()
    assert vessel_color_difference(image, vessel) == 0
    seen = []
    for step in (10, 20, 40):
        image[vessel] = 200 - step, 130 - 2 * step, 120 - 2 * step
        seen.append(vessel_color_difference(image, vessel))
    assert 0 < seen[0] < seen[1] < seen[2]


def test_each_block_counts_once() -> None:
    """A long vessel does not outweigh a short one elsewhere."""
    image, vessel = striped()
    image[vessel] = 160, 80, 80
    whole = vessel_color_difference(image, vessel)
    image[:, 140:160] = 200, 130, 120
    assert vessel_color_difference(image, vessel) == pytest.approx(whole / 2)


def test_brightness_alone_is_seen_too_and_grey_pictures_have_it() -> None:
    _, vessel = striped()
    grey = np.full(vessel.shape, 150, np.uint8)
    grey[vessel] = 120
    assert vessel_color_difference(grey, vessel) == pytest.approx(
        vessel_color_difference(np.repeat(grey[..., None], 3, axis=2), vessel)
    )
    assert vessel_color_difference(grey, vessel) > 5


def test_without_vessels_there_is_no_number() -> None:
    image = vessels()
    assert math.isnan(vessel_color_difference(image, np.zeros(image.shape[:2], bool)))
    assert math.isnan(vessel_color_difference(image, np.ones(image.shape[:2], bool)))
