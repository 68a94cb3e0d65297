from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from enhance import detail
from enhance.params import PForm
from tests.benchmarks import yardstick

JUST = 1e-9


def jump(sigma: float, form: PForm) -> float:
    return detail.exponent(sigma + JUST, form) - detail.exponent(sigma - JUST, form)


@pytest.mark.parametrize(
    ("sigma", "p"), [(0, 1.75), (2, 1.75), (3, 21 / 13), (6, 15 / 13), (9.5, 8 / 13), (10, 0.5), (100, 0.5)]
)
def test_p_as_printed(sigma: float, p: float) -> None:
    assert detail.exponent(sigma, "literal") == pytest.approx(p)


def test_literal_p_jumps_where_the_paper_does_and_nowhere_else() -> None:
    assert jump(2, "literal") == pytest.approx(23 / 13 - 7 / 4, abs=1e-6)
    assert jump(10, "literal") == pytest.approx(1 / 2 - 7 / 13, abs=1e-6)
    assert abs(jump(6, "literal")) < 1e-6


@given(st.floats(0, 127.5))
def test_continuous_p_has_no_jump_and_differs_little(sigma: float) -> None:
    assert abs(jump(max(sigma, 1e-6), "continuous")) < 1e-6
    literal, continuous = detail.exponent(sigma, "literal"), detail.exponent(sigma, "continuous")
    assert abs(literal - continuous) <= 1 / 26 + 1e-12
    assert 0.5 <= continuous <= 1.75


@pytest.mark.parametrize("p", [0.0, 0.5, 1.0, 1.75, 4.0])
def test_darker_than_around_gets_darker_and_brighter_gets_brighter(p: float) -> None:
    surround = np.full((1, 3), 0.5, dtype=np.float32)
    value = np.array([[0.3, 0.5, 0.7]], dtype=np.float32)
    ratio = yardstick.surround_ratio(value, surround, p)
    enhanced = yardstick.detailed(value, ratio)
    if p == 0:
        assert np.array_equal(enhanced, value)
        return
    assert ratio[0, 0] > 1
    assert ratio[0, 1] == 1
    assert ratio[0, 2] < 1
    assert enhanced[0, 0] < value[0, 0]
    assert enhanced[0, 2] > value[0, 2]


@pytest.mark.parametrize("p", [0.5, 1.75, 4.0])
def test_extreme_ratios_stay_finite_and_in_range(p: float) -> None:
    ends = np.array([[0, 0, 1, 1]], dtype=np.float32)
    surround = np.array([[0, 1, 0, 1]], dtype=np.float32)
    ratio = yardstick.surround_ratio(ends, surround, p)
    np.testing.assert_allclose(ratio, np.array([[1, 256**p, 256**-p, 1]]), rtol=1e-5)
    for brightened in (0.0, 1e-30, 0.2, 1.0):
        enhanced = yardstick.detailed(np.full_like(ends, brightened), ratio)
        assert np.all((enhanced >= 0) & (enhanced <= 1))
        assert np.all(enhanced == brightened) or 0 < brightened < 1


def test_square_root_is_the_power_of_a_half() -> None:
    rng = np.random.default_rng(8)
    value, surround = rng.random((2, 30, 40), dtype=np.float32)
    almost = yardstick.surround_ratio(value, surround, 0.5 + 1e-12)
    np.testing.assert_allclose(yardstick.surround_ratio(value, surround, 0.5), almost, rtol=1e-6)


def test_scales_weigh_the_same() -> None:
    one, two, three = (np.full((2, 2), level, dtype=np.float32) for level in (0.1, 0.2, 0.6))
    np.testing.assert_allclose(yardstick.mean_over_scales(iter((one, two, three))), 0.3, rtol=1e-6)
    assert np.array_equal(yardstick.mean_over_scales([one]), one)
    assert one[0, 0] == np.float32(0.1)
