"""The files of a sweep's table, read back by others' readers."""

from __future__ import annotations

import csv
import json
from dataclasses import fields, replace
from pathlib import Path

import pytest

from app.commands.described.sweeps import of_table
from app.enhancement.measures import Measures
from app.evaluation.evaluate import FrameMeasures
from app.sweeps.page import sweep_page
from app.sweeps.plan import SweepRecord
from app.sweeps.sections import all_jobs
from app.sweeps.settings import TaskName, settings_of
from app.sweeps.summary import Summary
from app.sweeps.table import COSTS, HEAD, Row, column_of, write_tables

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


def test_a_name_may_have_what_ends_a_line_elsewhere(tmp_path: Path) -> None:
    write_tables([replace(row, clip="a\u2028b\x85c") for row in TABLE], tmp_path)
    told = [of_table(tmp_path / name) for name in ("table.csv", "table.jsonl")]
    assert told[0] == told[1]
    assert ("jobs", "2: 1 finished, 1 failed") in [(fact.name, fact.text) for fact in told[1]]


def test_parquet_has_the_same_columns(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    write_tables(TABLE, tmp_path)
    read = parquet.read_table(tmp_path / "table.parquet").to_pylist()
    assert [one["z"] for one in read] == [None, 0.5]
    assert [one["on"] for one in read] == [True, False]
    assert read[1]["state"] == "failed"


def test_what_was_asked_for_stands_beside_what_was_measured(tmp_path: Path) -> None:
    asked, measured = {"n_gaussians": 8000, "vertices": 900}, {"n_gaussians": 7312.0, "vertices": 871.0}
    table = (
        Row("1", "x", "h", "finished", "", dict(asked), dict(measured), {"seconds": 2.0}),
        Row("2", "x", "h", "failed", "why", dict(asked), {}, {}),
    )
    write_tables(table, tmp_path)
    first, second = csv.DictReader((tmp_path / "table.csv").read_text().splitlines())
    assert (first["n_gaussians"], first["vertices"]) == (second["n_gaussians"], second["vertices"])
    assert (first["n_gaussians"], first["measured_n_gaussians"]) == ("8000", "7312.0")
    assert (first["vertices"], first["measured_vertices"]) == ("900", "871.0")
    jobs = all_jobs(Summary.of(table, ["n_gaussians"]))
    named = dict(zip([column.name for column in jobs.columns], jobs.rows[0], strict=True))
    assert (named["n_gaussians"], named["measured_n_gaussians"], named["vertices"]) == (8000, 7312.0, 871.0)


def test_no_setting_or_measure_has_the_name_of_another_column() -> None:
    tasks: tuple[TaskName, ...] = ("enhance", "train", "mesh")
    settings = {name for task in tasks for name in settings_of(task, {}).told()}
    settings |= set(settings_of("enhance", {"method": "vessel"}).told())
    measures = {field.name for kind in (Measures, FrameMeasures) for field in fields(kind)}
    measures |= {"images", "n_gaussians", "train_seconds", "wall_seconds", "vertices", "triangles", "bytes"}
    assert not (settings | measures) & {*HEAD, *COSTS}
    assert not {column_of(name, settings) for name in measures} & settings


def test_the_page_names_what_failed_and_escapes_names() -> None:
    record = SweepRecord(task="enhance", varied=("z",), jobs=("1", "2"))
    text = sweep_page(record, TABLE, "my sweep")
    assert "1 of 2 jobs are finished, 1 failed, 0 are left." in text
    assert "&lt;y&gt;.png" in text
    assert "<y>" not in text
