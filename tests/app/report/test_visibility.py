from __future__ import annotations

import numpy as np

from app.report.measures import paper
from app.report.visibility import COLUMNS, measured, methods, pattern, sample
from enhance.baselines import TAO_STAND_INS
from tests.enhance.pictures import vessels


def test_every_method_has_every_measure_and_the_original_changes_nothing() -> None:
    samples = [sample(vessels(72, 96, seed)) for seed in (1, 2)]
    rows = measured(methods(), samples)
    assert all(len(values) == len(COLUMNS) and np.isfinite(values[:3]).all() for values in rows.values())
    original = dict(zip(COLUMNS, rows["original"], strict=True))
    assert (original["noise"], original["black%"]) == (1, 0)
    assert abs(original["DV"] / original["BV"] / original["DV/BV"] - 1) < 0.5


def test_the_pattern_of_table_3_is_told_from_the_ratios() -> None:
    ratio = {"paper": 1.7, "original": 1.6, "wang2020": 1.4} | dict.fromkeys(TAO_STAND_INS, 0.7)
    ranks, shown, below = pattern(ratio)
    assert ranks.startswith("paper 1.70 > original 1.60 > wang2020 1.40")
    assert (shown, below) == (True, len(TAO_STAND_INS))
    assert pattern(ratio | {"original": 1.3})[1] is False
    assert pattern(ratio | {TAO_STAND_INS[0]: 2.0})[2] == len(TAO_STAND_INS) - 1


def test_table_3_has_a_heading_for_every_measure() -> None:
    table = paper._table_3("one clip", 1, {"vessel": np.arange(len(COLUMNS), dtype=np.float64)})
    assert len(table.columns) == len(table.rows[0]) == 1 + len(COLUMNS)
