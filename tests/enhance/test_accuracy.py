from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest

from enhance.accuracy import Row, accuracy
from tests.enhance.pictures import vessels

DATA = Path(__file__).resolve().parents[2] / "../shared/data"


@cache
def measured() -> tuple[Row, ...]:
    return tuple(accuracy(vessels(150, 200), repeats=1))


def group(name: str, rows: Sequence[Row] | None = None) -> dict[str, Row]:
    return {row.setting: row for row in rows or measured() if row.group == name}


def test_errors_are_in_order_and_times_are_there() -> None:
    for row in measured():
        assert 0 <= row.mean <= row.most
        assert 0 <= row.p999 <= row.most
        unbuilt = "means alone" in row.setting or "nearest" in row.setting
        assert (row.milliseconds is None) == unbuilt
        assert row.milliseconds is None or row.milliseconds > 0


def test_error_grows_with_subsampling_and_vanishes_without() -> None:
    rows = group("subsample")
    assert rows["s = 1"].mean < 1e-4
    assert rows["s = 1"].most <= 1
    means = [rows[f"s = {s}"].mean for s in (1, 2, 4, 8)]
    assert means == sorted(means)


def test_other_ways_to_sample_are_worse_than_the_own() -> None:
    own, rows = group("subsample")["s = 2"].mean, group("sampling")
    for name in ("rounded widths", "means alone", "nearest"):
        assert rows[f"s = 2, {name}"].mean > 1.1 * own
    for subsample in (2, 4, 8):
        one, two = rows[f"s = {subsample}, one grid"].mean, group("subsample")[f"s = {subsample}"].mean
        assert one <= two < 4 * one


def test_all_three_scales_come_closest() -> None:
    rows = group("scales")
    assert rows["4 + 16 + 64"].mean == min(row.mean for row in rows.values())
    assert rows["4 + 16 + 64"].mean == group("subsample")["s = 2"].mean


def test_tables_and_every_type_are_exact_to_their_rounding() -> None:
    rows = group("arithmetic")
    assert rows["uint8, tables"].most <= 1
    assert rows["uint8, tables"].mean <= 1e-4
    assert rows["uint16, direct powers"].most < 0.5 * 255 / 65535 + 1e-3
    for name in ("float32, direct powers", "float64, direct powers"):
        assert rows[name].most < 1e-3


def test_what_is_left_out_stays_below_its_bound() -> None:
    lean, whole = group("left out"), group("kept in")
    assert lean.keys() == whole.keys()
    for row in lean.values():
        assert row.bound is not None
        assert row.most <= row.bound + 1e-3
        assert row.bound <= 0.5


@pytest.mark.data
def test_subsampling_by_two_costs_a_twentieth_of_a_level_on_tissue() -> None:
    path = DATA / "scared/d1k1_rectified_pair/left.png"
    read = cv2.imread(str(path)) if path.exists() else None
    if read is None:
        pytest.skip("needs the real data beside the repository")
    image = np.ascontiguousarray(read[256:768, 320:960, ::-1], dtype=np.uint8)
    rows = [row for row, _ in zip(accuracy(image, repeats=1), range(2), strict=False)]
    assert group("subsample", rows)["s = 2"].mean < 0.05
