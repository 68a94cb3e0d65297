from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.report.diagrams import fitted


@given(st.floats(-2, 3), st.floats(0.01, 100))
def test_a_power_law_is_found_again(exponent: float, factor: float) -> None:
    work = (1.0, 3.0, 10.0, 40.0)
    found = fitted(work, [factor * w**exponent for w in work])
    assert found == pytest.approx((exponent, factor), abs=1e-6)


def test_one_amount_of_work_tells_nothing() -> None:
    assert math.isnan(fitted((2, 2), (1, 3))[0])
