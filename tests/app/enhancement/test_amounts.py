"""Brightness and colour as amounts: more to the right, and back to z and d as they were."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.enhancement.amounts import (
    AMOUNTS,
    FAINTEST,
    LEAST_D,
    MOST_D,
    brightness_of,
    color_of,
    d_factor_of,
    spaced,
    z_of,
)
from enhance import EnhanceParams
from enhance.saturation import Saturation, stretch

AMOUNT = st.floats(0, 1)
D_FACTOR = st.integers(1, 400).map(lambda hundredths: hundredths / 100)


@given(st.floats(0, 1))
def test_a_brightness_goes_back_to_its_z(z: float) -> None:
    assert z_of(brightness_of(z)) == pytest.approx(z, abs=2e-6)
    assert 0 <= brightness_of(z) <= 1


@given(st.just(0.0) | D_FACTOR)
def test_a_color_goes_back_to_its_d_factor(d_factor: float) -> None:
    assert d_factor_of(color_of(d_factor)) == d_factor
    assert d_factor_of(round(color_of(d_factor), 6)) == d_factor  # As a slider gives it.


@given(AMOUNT)
def test_a_color_on_the_slider_stays_where_it_was_put(color: float) -> None:
    back = color_of(d_factor_of(color))
    if FAINTEST <= color <= color_of(LEAST_D):
        assert back == pytest.approx(color, abs=0.005)
    assert d_factor_of(back) == d_factor_of(color)
    assert LEAST_D <= d_factor_of(color) <= MOST_D or d_factor_of(color) == 0 == back


@given(AMOUNT, AMOUNT)
def test_more_is_to_the_right(one: float, other: float) -> None:
    low, high = sorted((one, other))
    assert z_of(low) >= z_of(high)
    assert color_of(d_factor_of(low)) <= color_of(d_factor_of(high))


def test_nothing_is_unchanged_and_the_paper_s_is_in_the_middle() -> None:
    assert (z_of(0.0), brightness_of(1.0)) == (1.0, 0.0)
    assert (d_factor_of(0.0), color_of(0.0)) == (0.0, 0.0)
    assert (d_factor_of(0.5), color_of(1.0)) == (1.0, 0.5)
    assert (d_factor_of(0.09), d_factor_of(0.1), d_factor_of(0.2)) == (0.0, MOST_D, MOST_D)


def test_values_are_evenly_spaced_in_what_they_do() -> None:
    assert spaced("z", 1.0, 0.0, 3) == (1.0, 0.5, 0.0)
    assert spaced("d_factor", 4.0, 0.25, 3) == (4.0, 1.0, 0.25)
    assert spaced("d_factor", 1.0, 1.0, 2) == spaced("d_factor", 1.0, 4.0, 1) == (1.0,)
    assert spaced("eps", 0.01, 0.1, 3) is None


@given(st.floats(0.05, 0.95), D_FACTOR)
def test_a_color_is_the_saturation_that_comes_of_what_the_paper_gives_a_half(
    mean: float, d_factor: float
) -> None:
    """The place of the stretch with k = 1 where S* is 0.5: what other k make of it."""
    chroma = np.linspace(0, 1, 4001, dtype=np.float32)[None]
    saturation = Saturation(chroma, 1 - chroma)
    half = int(np.abs(stretch(saturation, mean, 1.0)[0] - 0.5).argmin())
    assert stretch(saturation, mean, d_factor)[0, half] == pytest.approx(color_of(d_factor), abs=0.01)


def test_each_says_the_paper_s_value() -> None:
    assert AMOUNTS["z"].explained(0.07).endswith("Now z 0.07 in Eq 1.")
    assert AMOUNTS["d_factor"].explained(0.5).endswith("Now d-factor 0.50 in Eq 11.")
    assert AMOUNTS["z"].explained(None) == AMOUNTS["z"].text
    assert set(AMOUNTS) <= set(EnhanceParams.__dataclass_fields__)
