from __future__ import annotations

import cv2
import numpy as np
import pytest

from assets import phantom_path
from enhance import EnhanceParams
from enhance.stability import ranges, stability
from enhance.stability_row import Row
from tests.enhance.pictures import vessels


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    return list(stability(vessels(96, 130)))


def test_every_row_passes(rows: list[Row]) -> None:
    assert len(rows) > 100
    assert [row for row in rows if not row.passed] == []


def test_every_row_passes_on_tissue_with_tools_and_highlights() -> None:
    first = min((phantom_path() / "images").iterdir())
    tissue = np.asarray(cv2.imread(str(first), cv2.IMREAD_COLOR_RGB), np.uint8)
    assert [row for row in stability(tissue) if not row.passed] == []


def test_every_parameter_with_a_range_is_among_the_rows(rows: list[Row]) -> None:
    names = {name for name, _, _ in ranges()}
    assert names == {"z", "p", "radii", "eps", "subsample", "d_factor", "strength"}
    cases = [row.case for row in rows]
    for name, low, high in ranges():
        assert EnhanceParams.__dataclass_fields__[name]
        assert f"{name} = {low:g}" in cases
        assert f"{name} = {high:g}" in cases


def test_each_case_is_there_once(rows: list[Row]) -> None:
    cases = [(row.hazard, row.case) for row in rows]
    assert len(set(cases)) == len(cases)


def test_what_keep_black_does_is_shown(rows: list[Row]) -> None:
    measured = {row.case: row.measured for row in rows if row.hazard == "noise at black"}
    assert measured["largest step of one code, Eq 1"] == 32
    assert measured["largest step of one code, with keep_black"] <= 7


@pytest.mark.parametrize("measured", [1.1, float("nan"), float("inf")])
def test_a_row_above_its_bar_or_not_a_number_fails(measured: float) -> None:
    assert not Row("hazard", "case", measured, 1.0).passed
