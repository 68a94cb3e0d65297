"""The files of a sweep's table, read back by others' readers."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from app.sweeps.page import sweep_page
from app.sweeps.plan import SweepRecord
from app.sweeps.table import Row, write_tables

TABLE = (
    Row(
        "1",
        "x.png",
        "h",
        "finished",
        "",
        {"z": None, "radii": "4/16", "on": True},
        {"dv": 1.5, "bv": None},
        {"seconds": 2.0, "machine": "m"},
    ),
    Row("2", "<y>.png", "h", "failed", 'why, "quoted"', {"z": 0.5, "radii": "4/8", "on": False}, {}, {}),
)


def test_csv_and_json_lines_hold_every_value(tmp_path: Path) -> None:
    paths = write_tables(TABLE, tmp_path)
    read = list(csv.DictReader((tmp_path / "table.csv").read_text().splitlines()))
    assert [one["reason"] for one in read] == ["", 'why, "quoted"']
    assert read[0]["dv"] == "1.5"
    assert read[0]["z"] == read[0]["bv"] == read[1]["dv"] == ""
    lines = [json.loads(line) for line in (tmp_path / "table.jsonl").read_text().splitlines()]
    assert lines == [row.flat() for row in TABLE]
    assert paths[0] == tmp_path / "table.csv"


def test_parquet_has_the_same_columns(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    write_tables(TABLE, tmp_path)
    read = parquet.read_table(tmp_path / "table.parquet").to_pylist()
    assert [one["z"] for one in read] == [None, 0.5]
    assert [one["on"] for one in read] == [True, False]
    assert read[1]["state"] == "failed"


def test_the_page_names_what_failed_and_escapes_names() -> None:
    record = SweepRecord(task="enhance", varied=("z",), jobs=("1", "2"))
    text = sweep_page(record, TABLE, "my sweep")
    assert "1 of 2 jobs are finished, 1 failed, 0 are left." in text
    assert "&lt;y&gt;.png" in text
    assert "<y>" not in text
