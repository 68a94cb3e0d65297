"""Error against run time of reconstruction: every method, short and long, on original and enhanced frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from app.report.bench import Bench, Clock, measured_frames
from app.report.outcomes import Run, diagrams, grouped, setting_of, table
from app.report.runs import PUBLISHED, SEEDS, STEPS, schedule
from app.report.section import Plate, Section
from app.runs.run_folder import Input
from app.runs.wall_clock import WALL
from renderer.clip import Clip
from renderer.measuring.training_accuracy import outcome
from renderer.train.config import TrainConfig
from renderer.train.trainer import TrainingError

TITLE: Final = "Reconstruction: error against run time"
REPEATS: Final = 2
"""Of the other runs on the phantom, for their time alone."""
INPUTS: Final[tuple[Input, ...]] = ("original", "enhanced")


def measure(bench: Bench, clock: Clock) -> Section:
    """See the file."""
    if bench.why_untrained is not None:
        return Section(title=TITLE, not_measured=(bench.why_untrained,))
    default = schedule(bench.clip)
    missing: list[str] = []
    runs = _finished(bench, clock, missing)
    return Section(
        title=TITLE,
        sentences=(
            f"{bench.clip.name}: {len(bench.clip)} frames of {bench.clip.size[0]}x{bench.clip.size[1]}, "
            f"measured on {measured_frames(bench.clip)} against the frames a run was trained on. "
            "Diagrams and `s training` give the seconds of training steps alone, kernels "
            f"compiled; `s in total`: {WALL}. Settings with several runs have as many seeds; a seed "
            "reproduces the same figures, and settings with one seed are timed again. On original frames "
            f"{' and '.join(PUBLISHED)} are also trained at their published length, 3000 steps.",
        ),
        plates=tuple(
            Plate(title=f"Reconstruction of {name} frames", diagrams=diagrams(those, default))
            for name, those in runs.items()
            if those
        ),
        tables=(
            table(
                [run for those in runs.values() for run in those],
                "Every method and parameter",
                "Means over the frames and runs; training seconds are the median of all times, ± half "
                "their range. MB: the model's parameters with their two moments. Without a number of "
                "iterations: the default, 3000.",
            ),
        ),
        not_measured=tuple(missing),
    )


def _finished(bench: Bench, clock: Clock, missing: list[str]) -> dict[Input, list[Run]]:
    default, is_short = schedule(bench.clip), bench.truth is not None
    runs: dict[Input, list[Run]] = {name: [] for name in INPUTS}
    for config, kind in _wanted(bench.clip, default, SEEDS if is_short else 1):
        again = f", seed {config.seed}" if config.seed != default.seed else ""
        name = f"{setting_of(config)}{again}, {kind} frames"
        if clock.is_out:
            missing.append(f"{name}: no time left")
            continue
        try:
            trained = bench.runs.trained(config, kind)
        except TrainingError as error:
            missing.append(f"{name}: {error}")
            continue
        found = outcome(trained.finished, trained.clip, config, bench.truth)
        runs[kind].append(Run(config=config, input=kind, outcome=found))
    for _ in range(REPEATS if is_short else 0):
        runs = {kind: _timed_again(bench, clock, those) for kind, those in runs.items()}
    return runs


def _timed_again(bench: Bench, clock: Clock, runs: list[Run]) -> list[Run]:
    """Those that are alone with their setting."""
    alone = {group[0] for group in grouped(runs) if len(group) == 1}
    return [
        replace(run, times=(*run.times, bench.runs.seconds_again(run.config, run.input)))
        if run in alone and not clock.is_out
        else run
        for run in runs
    ]


def _wanted(clip: Clip, default: TrainConfig, seeds: int) -> Iterator[tuple[TrainConfig, Input]]:
    """The long ones come first: other parts need them, too."""
    for kind in INPUTS:
        for method in STEPS:
            yield schedule(clip, method), kind
        for method, counts in STEPS.items():
            for count in counts[1:]:
                yield replace(schedule(clip, method), iterations=count), kind
    usual = default.n_gaussians
    for count in (usual // 4, usual // 2, 2 * usual):
        yield replace(default, n_gaussians=count), "original"
    for controls in sorted({4, max(4, len(clip) // 2)}):
        yield replace(default, n_controls=controls), "original"
    for share in (0.0, 2 / 3):
        yield replace(default, half_resolution_share=share), "original"
    for seed in range(default.seed + 1, default.seed + seeds):
        for kind in INPUTS:
            for method in STEPS:
                yield replace(schedule(clip, method), seed=seed), kind
    # The longest of all: where time is short, these are missing alone.
    for seed in range(default.seed, default.seed + seeds):
        for method, count in PUBLISHED.items():
            yield replace(schedule(clip, method), iterations=count, seed=seed), "original"
