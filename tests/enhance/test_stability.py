from __future__ import annotations

import pytest

from enhance import EnhanceParams
from enhance.stability import Row, ranges, stability
from tests.enhance.pictures import vessels

ROWS = list(stability(vessels(96, 130)))


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.hazard}: {row.case}")
def test_every_row_passes(row: Row) -> None:
    assert row.passed, f"{row.measured:g} {row.unit}, expected at most {row.bar:g}"


def test_every_parameter_with_a_range_is_among_the_rows() -> None:
    names = {name for name, _, _ in ranges()}
    assert names == {"z", "p", "radii", "eps", "subsample", "d_factor", "strength"}
    cases = [row.case for row in ROWS]
    for name, low, high in ranges():
        assert EnhanceParams.__dataclass_fields__[name]
        assert f"{name} = {low:g}" in cases
        assert f"{name} = {high:g}" in cases


def test_each_case_is_there_once() -> None:
    cases = [(row.hazard, row.case) for row in ROWS]
    assert len(set(cases)) == len(cases)


def test_what_keep_black_does_is_shown() -> None:
    measured = {row.case: row.measured for row in ROWS if row.hazard == "noise at black"}
    assert measured["largest step of one code, Eq 1"] == 32
    assert measured["largest step of one code, with keep_black"] <= 7


@pytest.mark.parametrize("measured", [1.1, float("nan"), float("inf")])
def test_a_row_above_its_bar_or_not_a_number_fails(measured: float) -> None:
    assert not Row("hazard", "case", measured, 1.0).passed
