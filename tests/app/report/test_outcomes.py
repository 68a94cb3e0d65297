from __future__ import annotations

import math
from dataclasses import replace

from app.report.outcomes import Run, diagrams, setting_of, table
from renderer.measuring.training_accuracy import Outcome
from renderer.train.config import TrainConfig

OUTCOME = Outcome(
    psnr=30.0, psnr_masked=29.0, psnr_tissue=28.0, psnr_seldom=math.nan, coverage=0.99, specks=3.0, ssim=0.9,
    depth_rmse=1.5, motion_rmse=math.nan, psnr_behind_tools=math.nan, seconds=10.0, megabytes=2.0,
    n_gaussians=7, iterations=100,
)  # fmt: skip
DEFAULT = TrainConfig(iterations=1000, n_gaussians=500)


def run(seconds: float = 10.0, **changes: object) -> Run:
    config = replace(DEFAULT, **changes)  # type: ignore[arg-type]
    return Run(config=config, input="original", outcome=replace(OUTCOME, seconds=seconds))


def test_a_setting_is_called_by_what_differs() -> None:
    assert setting_of(TrainConfig()) == "vesselsplat"
    assert setting_of(replace(DEFAULT, method="static")) == "static, iterations 1000, n_gaussians 500"


def test_what_a_run_goes_without_is_a_series_of_its_own() -> None:
    runs = [run(), run(leave_out=("tracks",)), run(leave_out=("tracks", "color_curves"), iterations=250)]
    points = diagrams(runs, DEFAULT)[0].points
    assert [(point.series, point.setting) for point in points] == [
        ("vesselsplat", "1000 steps"), ("vesselsplat without tracks", "1000 steps"),
        ("vesselsplat without color curves and tracks", "250 steps"),
    ]  # fmt: skip


def test_seeds_become_one_point_with_a_spread_and_the_default_is_marked() -> None:
    runs = [run(10.0), run(14.0, seed=1), run(3.0, iterations=250), run(5.0, method="static")]
    by_measure = {diagram.measure: diagram for diagram in diagrams(runs, DEFAULT)}
    assert "motion RMSE, mm" not in by_measure
    points = by_measure["PSNR, dB"].points
    assert [(point.series, point.setting) for point in points] == [
        ("vesselsplat", "1000 steps"), ("vesselsplat", "250 steps"), ("static", "1000 steps"),
    ]  # fmt: skip
    assert (points[0].seconds, points[0].spread) == (12.0, 2.0)
    assert [point.is_default for point in points] == [True, False, False]
    assert abs(by_measure["1 - SSIM"].points[0].error - 0.1) < 1e-12


def test_further_times_of_a_run_steady_its_seconds_and_nothing_else() -> None:
    runs = [replace(run(10.0), times=(30.0, 11.0)), run(3.0, iterations=250)]
    point, single = diagrams(runs, DEFAULT)[0].points
    assert (point.seconds, point.spread, point.error) == (11.0, 10.0, OUTCOME.psnr)
    assert (single.seconds, single.spread) == (3.0, 0.0)
    made = table(runs, "t")
    names = [column.name for column in made.columns]
    assert [made.rows[0][names.index(name)] for name in ("runs", "s training", "± s")] == [1, 11.0, 10.0]
    assert [made.rows[1][names.index(name)] for name in ("s training", "± s")] == [3.0, None]


def test_the_table_has_a_row_for_each_setting() -> None:
    made = table([run(), run(seed=1), run(iterations=250)], "t")
    assert len(made.rows) == 2
    assert all(len(row) == len(made.columns) for row in made.rows)
    assert made.rows[0][2] == 2


def test_the_time_in_all_stands_beside_that_of_the_steps() -> None:
    timed = [
        replace(run(10.0, seed=seed), outcome=replace(OUTCOME, wall_seconds=16.0 + seed)) for seed in (0, 1)
    ]
    made = table([*timed, run(3.0, iterations=250)], "t")
    place = [column.name for column in made.columns].index("s in total")
    assert [row[place] for row in made.rows] == [16.5, None]
