from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from enhance import EnhanceParams, brightness, enhance

LEVELS = np.arange(256, dtype=np.float32)[None] / np.float32(255)
FACTORS = st.floats(0.0, 1.0)


@given(FACTORS)
def test_brightening_never_darkens_keeps_order_and_fixes_white(z: float) -> None:
    lifted = brightness.brighten(LEVELS, z)
    assert lifted.dtype == np.float32
    assert np.all(np.diff(lifted) > 0)
    assert np.all(lifted >= LEVELS - 1e-7)
    assert lifted[0, 255] == 1
    np.testing.assert_allclose(lifted[0, 0], 0.2 * (1 - z), atol=1e-7)


def test_brightening_at_one_is_exactly_nothing() -> None:
    values = np.random.default_rng(1).random((50, 61), dtype=np.float32)
    assert np.array_equal(brightness.brighten(values, 1.0), values)


def test_brightening_at_zero_maps_the_darkest_levels_far_apart() -> None:
    lifted = 255 * brightness.brighten(LEVELS[:, :4], 0.0)
    assert np.rint(lifted).tolist() == [[51, 83, 89, 92]]


@pytest.mark.parametrize(
    ("level", "z"), [(0, 0), (50, 0), (51, 0.01), (100, 0.5), (149, 0.99), (150, 1), (255, 1)]
)
def test_z_follows_the_level(level: int, z: float) -> None:
    assert brightness.z_from_level(level) == pytest.approx(z, abs=1e-12)


@given(st.lists(st.integers(0, 255), min_size=1, max_size=60))
def test_level_is_the_smallest_that_a_tenth_of_all_pixels_reach(levels: list[int]) -> None:
    found = brightness.level(np.bincount(levels, minlength=256).cumsum())

    def share(level: int) -> Fraction:
        return Fraction(sum(one <= level for one in levels), len(levels))

    assert share(found) >= Fraction(1, 10)
    assert found == 0 or share(found - 1) < Fraction(1, 10)


def test_histogram_counts_rounded_levels() -> None:
    histogram = brightness.value_histogram(np.array([[0, 0.49 / 255, 0.51 / 255]], dtype=np.float32))
    assert histogram.shape == (256,)
    assert histogram[:2].tolist() == [2, 1]
    assert histogram.sum() == 3


def faded(value: NDArray[np.float32], z: float) -> NDArray[np.float32]:
    """A grey float image after Eq 1 and the fade alone."""
    return np.asarray(enhance(value, EnhanceParams(z=z, p=0.0, keep_black=True)).image)


@settings(deadline=None)
@given(FACTORS)
def test_fade_keeps_black_order_and_everything_above_24_levels(z: float) -> None:
    dark = faded(LEVELS, z)
    assert dark[0, 0] == 0
    assert np.all(np.diff(dark) > 0)
    np.testing.assert_allclose(dark[:, 24:], brightness.brighten(LEVELS, z)[:, 24:], atol=4e-7)
    assert 255 * np.diff(dark).max() < 7.1  # 31.7 without the fade, at z = 0


def test_fade_has_no_kink() -> None:
    fine = np.linspace(10 / 255, 40 / 255, 30_001)[None].astype(np.float32)
    lift = brightness.brighten(fine.astype(np.float64), 0.0) - fine
    weight = (faded(fine, 0.0) - fine) / lift
    slope = np.diff(weight[0, ::100])
    assert np.abs(np.diff(slope)).max() < 1e-3  # a straight ramp of the same width bends by 4e-3
