"""Finished runs as tables and diagrams: error against run time of reconstruction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from app.files.provenance import strict_json
from app.report.diagrams import Diagram, Point
from app.report.section import Column, Table
from app.runs.run_folder import Input
from renderer.json_files import parsed
from renderer.measuring.training_accuracy import Outcome
from renderer.train.config import TrainConfig

MEASURES: Final = {
    "psnr": ("PSNR, dB", True),
    "dissimilarity": ("1 - SSIM", False),
    "depth_rmse": ("depth RMSE", False),
    "motion_rmse": ("motion RMSE, mm", False),
}
SAID: Final = {
    "iterations": "{} steps",
    "n_gaussians": "{} Gaussians",
    "n_controls": "{} control values",
    "half_resolution_share": "{} of the steps at half size",
}
"""Labels of points, by the setting that is changed; others are called by their names."""
COLUMNS: Final = (
    *(Column("setting"), Column("frames"), Column("runs"), Column("PSNR, dB", ".2f", "high")),
    *(Column("over evaluated pixels, dB", ".2f", "high"), Column("all tissue, dB", ".2f", "high")),
    *(Column("seldom seen, dB", ".2f", "high"), Column("behind tools, dB", ".2f", "high")),
    *(
        Column("tissue covered", ".1%", "high"),
        Column("specks, px", ".0f", "low"),
        Column("SSIM", ".4f", "high"),
    ),
    *(Column("depth RMSE", ".3f", "low"), Column("motion RMSE, mm", ".3f", "low")),
    *(Column("s training", ".1f", "low"), Column("± s", ".1f"), Column("s in total", ".1f", "low")),
    *(Column("MB", ".1f", "low"), Column("Gaussians")),
)


@dataclass(frozen=True, kw_only=True)
class Run:
    """One that is finished, and what it came to."""

    config: TrainConfig
    input: Input
    outcome: Outcome
    times: tuple[float, ...] = ()
    """Seconds of further runs, which came to the same."""

    @property
    def setting(self) -> str:
        """See setting_of."""
        return setting_of(self.config)

    def value(self, measure: str) -> float:
        """One of MEASURES, or a field of the outcome."""
        return 1 - self.outcome.ssim if measure == "dissimilarity" else float(getattr(self.outcome, measure))


def setting_of(config: TrainConfig) -> str:
    """The method, and what differs from the default."""
    default, own = (parsed(strict_json(each)) for each in (TrainConfig(), config))
    changed = [
        f"{name} {round(value, 2) if isinstance(value, float) else value}"
        for name, value in own.items()
        if value != default[name] and name not in ("method", "seed", "hold_out", "leave_out")
    ]
    return ", ".join([_kind(config), *changed])


def _kind(config: TrainConfig) -> str:
    """The method, and what it goes without."""
    left = [part.replace("_", " ") for part in config.leave_out]
    return f"{config.method} without {' and '.join(left)}" if left else config.method


def grouped(runs: Sequence[Run]) -> list[list[Run]]:
    """The seeds of each setting and input."""
    groups: dict[tuple[str, str], list[Run]] = {}
    for run in runs:
        groups.setdefault((run.setting, run.input), []).append(run)
    return list(groups.values())


def mean(group: Sequence[Run], measure: str) -> float:
    """Over the runs where it was measured; NaN where in none."""
    values = [run.value(measure) for run in group if math.isfinite(run.value(measure))]
    return float(np.mean(values)) if values else math.nan


def seconds(group: Sequence[Run]) -> tuple[float, float]:
    """Median of all times, since other load slows single runs; half the distance of the extremes."""
    times = [time for run in group for time in (run.outcome.seconds, *run.times)]
    return float(np.median(times)), (max(times) - min(times)) / 2


def wall_seconds(group: Sequence[Run]) -> float | None:
    """Median of what the runs took in all; None where that is not recorded."""
    times = [run.outcome.wall_seconds for run in group if math.isfinite(run.outcome.wall_seconds)]
    return float(np.median(times)) if times else None


def diagrams(runs: Sequence[Run], default: TrainConfig) -> tuple[Diagram, ...]:
    """One for each measure that was taken; settings are called by what differs from `default`."""
    usual = setting_of(default).split(", ")[1:]
    made = [
        Diagram(
            measure=label,
            more_is_better=more_is_better,
            points=tuple(
                Point(
                    series=_kind(group[0].config),
                    setting=_label(group[0], usual),
                    seconds=seconds(group)[0],
                    spread=seconds(group)[1],
                    error=mean(group, measure),
                    is_default=replace(group[0].config, seed=default.seed) == default,
                )
                for group in grouped(runs)
                if math.isfinite(mean(group, measure))
            ),
        )
        for measure, (label, more_is_better) in MEASURES.items()
    ]
    return tuple(diagram for diagram in made if diagram.points)


def _label(run: Run, usual: Sequence[str]) -> str:
    changed = [part.split(" ") for part in run.setting.split(", ")[1:] if part not in usual]
    named = [SAID[name].format(" ".join(value)) for name, *value in changed if name in SAID]
    others = [" ".join(part) for part in changed if part[0] not in SAID]
    return ", ".join([*named, *others]) or SAID["iterations"].format(run.config.iterations)


def table(runs: Sequence[Run], title: str, note: str = "") -> Table:
    """Means over the seeds of each setting, and the median of their seconds."""
    measures = (
        *("psnr", "psnr_masked", "psnr_tissue", "psnr_seldom", "psnr_behind_tools", "coverage", "specks"),
        *("ssim", "depth_rmse", "motion_rmse"),
    )
    return Table(
        title=title,
        columns=COLUMNS,
        rows=tuple(
            (
                *(group[0].setting, group[0].input, len(group)),
                *(mean(group, measure) for measure in measures),
                seconds(group)[0],
                seconds(group)[1] or None,
                wall_seconds(group),
                mean(group, "megabytes"),
                round(mean(group, "n_gaussians")),
            )
            for group in grouped(runs)
        ),
        note=note,
    )
