"""Means, spreads and differences of a sweep, against figures worked out by hand."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from app.sweeps.plan import SweepRecord, read_sweep
from app.sweeps.sections import best, by_clip, differences, over_all, sections
from app.sweeps.settings import TaskName
from app.sweeps.summary import Difference, Spread, Summary, quantile, said
from app.sweeps.table import Row


def row(clip: str, method: str, seed: int, **measures: float | None) -> Row:
    return Row(
        job=f"{clip}{method}{seed}",
        clip=clip,
        clip_sha256=clip,
        state="finished",
        reason="",
        settings={"method": method, "seed": seed, "iterations": 9},
        measures=dict(measures),
        costs={"seconds": 2.0 if method == "a" else 3.0},
    )


@pytest.fixture
def summary() -> Summary:
    rows = [
        row("x", "a", 0, psnr=30.0, bv=1.0),
        row("x", "a", 1, psnr=32.0, bv=3.0),
        row("y", "a", 0, psnr=20.0, bv=5.0),
        row("x", "b", 0, psnr=31.0, bv=1.0),
        row("x", "b", 1, psnr=34.0, bv=2.0),
        row("y", "b", 0, psnr=None, bv=1.0),
    ]
    failed = Row("f", "x", "x", "failed", "why", {"method": "c", "seed": 0}, {}, {})
    return Summary.of([*rows, failed], ["method"])


A, B = (("method", "a"),), (("method", "b"),)


def test_spread_over_seeds_and_over_clips(summary: Summary) -> None:
    assert summary.settings == (A, B)
    assert summary.spread(A, "psnr", "x") == Spread(2, 31.0, pytest.approx(math.sqrt(2)))
    assert summary.spread(A, "bv", "x") == Spread(2, 2.0, pytest.approx(math.sqrt(2)))
    assert summary.spread(A, "bv") == Spread(2, 3.5, pytest.approx(3 / math.sqrt(2)))
    # Of y, b has no PSNR.
    assert summary.spread(A, "psnr") == Spread(1, 31.0, pytest.approx(math.nan, nan_ok=True))
    assert summary.spread(B, "psnr").count == 1


def test_differences_are_of_the_same_clip_and_seed(summary: Summary) -> None:
    found = summary.difference(B, A, "psnr")
    assert found.spread.count == 2
    assert found.spread.mean == 1.5
    # Two pairs, 1 and 2: t(1) * s / sqrt(2) = 12.706 * 0.7071 / 1.4142.
    assert found.half_width == pytest.approx(12.706 / 2)
    assert not found.is_clear
    assert found.over == "seed"
    assert summary.difference(B, A, "bv").over == "clip"
    (table,) = differences(summary, ["psnr", "bv"])
    # BV: of x, 0 and -1; of y, -4.
    assert [row[1:4] for row in table.rows] == [("psnr", "2 seeds", 1.5), ("bv", "2 clips", -2.25)]
    assert [row[-1] for row in table.rows] == ["no", "no"]


def test_one_clip_with_one_seed_does_not_say_whether_settings_differ(summary: Summary) -> None:
    alone = Summary(summary.varied, tuple(row for row in summary.rows if row.settings["seed"] == 0))
    (table,) = differences(alone, ["psnr"])
    assert [(row[2], row[-1]) for row in table.rows] == [("1 clip", None)]


def test_the_best_setting_is_the_largest_or_the_smallest_as_the_measure_means(summary: Summary) -> None:
    assert summary.best("psnr", "x") == B
    assert summary.best("bv", "x") == B
    assert summary.best("psnr") == B
    assert summary.best("psnr", "y") == A
    assert summary.best("ssim") is None


@pytest.mark.parametrize(
    ("task", "lengths"), [("train", ["depth_rmse"]), ("mesh", ["surface", "surface_95"])]
)
def test_lengths_of_clips_without_millimetres_are_shown(task: TaskName, lengths: list[str]) -> None:
    measures = dict.fromkeys(lengths, 0.5)
    record = SweepRecord(task=task, varied=("method",), jobs=("xa0", "xb0"))
    told = sections(record, [row("x", "a", 0, **measures), row("x", "b", 0, **measures)])
    assert [line[0] for line in told["best"].tables[0].rows] == [name for name in lengths for _ in range(2)]
    assert [one.measure for plate in told["settings"].plates for one in plate.diagrams] == [
        name.replace("_", " ") for name in lengths
    ]


def test_no_setting_is_best_by_a_count() -> None:
    found = Summary.of([row("x", "a", 0, images=8.0, bytes=9.0), row("x", "b", 0, images=7.0)], ["method"])
    assert found.spread(B, "images").mean == 7.0
    assert found.best("images") is None
    assert found.best("bytes") == A
    assert [line[0] for line in best(found, ["images", "bytes"]).rows] == ["bytes"]
    columns = {column.name: column.best for column in over_all(found, ["images", "bytes"]).columns}
    assert (columns["images"], columns["bytes"]) == ("", "low")


def test_the_diagram_has_a_point_a_setting(summary: Summary) -> None:
    points = {point.setting: (point.seconds, point.error) for point in summary.diagram("psnr").points}
    assert points == {"method a": (2.0, 31.0), "method b": (3.0, 32.5)}
    assert summary.diagram("psnr").more_is_better
    assert not summary.diagram("bv").more_is_better


@pytest.mark.parametrize(
    ("freedom", "value"),
    [(1, 12.7062), (9, 2.2622), (21, 2.0796), (30, 2.0423), (60, 2.0003), (1000, 1.9623)],
)
def test_quantiles_of_students_t(freedom: int, value: float) -> None:
    assert quantile(freedom) == pytest.approx(value, abs=1e-3)


def test_equal_values_differ_clearly_from_zero_unless_they_are_zero() -> None:
    assert Difference.of([[1.0, 1.0, 1.0]]).is_clear
    assert Difference.of([[1.0], [1.0], [1.0]]).is_clear
    assert not Difference.of([[0.0, 0.0]]).is_clear
    assert not Difference.of([[5.0]]).is_clear
    assert Difference.of([]).spread.count == 0


def test_seeds_of_a_clip_are_no_further_clips() -> None:
    # Means over seeds: 2, 4 and 0; t(2) * s / sqrt(3) = 4.303 * 2 / 1.732.
    found = Difference.of([[1.9, 2.0, 2.1], [4.0, 4.0], [0.0]])
    assert (found.over, found.spread.count, found.spread.mean) == ("clip", 3, pytest.approx(2.0))
    assert found.half_width == pytest.approx(4.303 * 2 / math.sqrt(3))
    assert not found.is_clear
    again = Difference.of([[1.9, 2.0, 2.1] * 10, [4.0] * 20, [0.0] * 30])
    assert again.half_width == pytest.approx(found.half_width)


def test_differences_without_an_effect_are_clear_in_five_of_a_hundred_sweeps() -> None:
    """Each clip favours one or the other of two methods, on average neither; seeds vary little."""
    random = np.random.default_rng(0)
    effects = random.normal(0, 1.0, (2000, 4, 1)) + random.normal(0, 0.05, (2000, 4, 3))
    share = np.mean([Difference.of(sweep.tolist()).is_clear for sweep in effects])
    assert 0.035 < share < 0.065


def test_what_is_left_to_the_program_is_auto() -> None:
    assert said((("z", None), ("p", 0.5))) == "z auto, p 0.5"


def test_every_column_has_a_name_of_its_own(summary: Summary) -> None:
    measures = ("psnr", "bv")
    tables = (over_all(summary, measures), by_clip(summary, measures), *differences(summary, measures))
    for table in tables:
        names = [column.name for column in table.columns]
        assert len(set(names)) == len(names)
    assert [column.name for column in tables[0].columns] == [
        "setting",
        "clips",
        "psnr",
        "psnr ±",
        "bv",
        "bv ±",
    ]
    assert [column.name for column in tables[2].columns][4:6] == ["difference from", "difference to"]


def test_a_record_of_before_with_names_as_flags_have_them_tells_settings_apart(tmp_path: Path) -> None:
    written = {"task": "train", "varied": ["n-gaussians"], "jobs": ["1"]}
    (tmp_path / "sweep.json").write_text(json.dumps(written))
    assert read_sweep(tmp_path).varied == ("n_gaussians",)
