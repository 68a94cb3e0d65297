"""Error against run time of reconstruction: every method and knob, as a table, a plot and JSON.

python -m tests.benchmarks.train_accuracy CLIP --out DIR [--knobs NAME ...] [--methods NAME ...] [--seeds N]
    [--input original|enhanced] [--held-out] [--finished]

CLIP is a folder, or "phantom", whose true motion is known. Methods run with every seed, the other knobs with
the first alone. Every run has its folder in DIR; one that is there already goes on or is measured as it is;
with --finished nothing else is. Measured on test frames; with --held-out on training frames that are kept out
of the fit, for choosing. `vesselsplat report --parts training` does the same with short runs.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import get_args

from app.files.atomic import write_bytes
from app.files.provenance import provenance, strict_json
from app.files.records import Source
from app.report.bench import PHANTOM as PARAMS
from app.report.diagrams import pareto_front
from app.report.outcomes import Run, diagrams, grouped, mean, setting_of
from app.report.plots import diagrams_figure
from app.runs.run_folder import RunFolder
from app.runs.train_run import TrainRequest, run_training
from app.runs.trained_clip import input_clip, run_clip
from renderer.measuring.training_accuracy import outcome
from renderer.phantom import Phantom, write_phantom
from renderer.sources import open_clip
from renderer.train.config import Method, TrainConfig
from renderer.train.events import Finished
from tests.benchmarks.train_settings import KNOBS, settings

PHANTOM = "phantom"
COLUMNS = {
    "psnr": ".2f", "psnr_masked": ".2f", "psnr_tissue": ".2f", "psnr_seldom": ".2f",
    "psnr_behind_tools": ".2f", "coverage": ".4f", "specks": ".0f", "ssim": ".4f",
    "depth_rmse": ".3f", "motion_rmse": ".3f",
}  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("clip", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--knobs", nargs="+", choices=list(KNOBS), default=list(KNOBS))
    methods = get_args(Method)
    parser.add_argument("--methods", nargs="+", choices=methods, default=methods)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--input", choices=("original", "enhanced"), default="original")
    parser.add_argument("--held-out", action="store_true")
    parser.add_argument("--finished", action="store_true")
    flags = parser.parse_args()
    flags.out.mkdir(parents=True, exist_ok=True)
    path, truth = flags.clip, None
    if str(path) == PHANTOM:
        path, truth = flags.out / PHANTOM, Phantom(PARAMS)
        if not path.exists():
            write_phantom(path, PARAMS)
    clip = open_clip(path)
    runs = [
        (knob, config)
        for knob, config in wanted(flags)
        if not flags.finished or folder(config, flags).is_finished
    ]
    rows = [measured(path, config, truth, flags) for _, config in runs]
    show(rows)
    machine = {"system": platform.platform(), "cores": os.cpu_count(), "load": os.getloadavg()[0]}
    told = [{"setting": run.setting, "config": run.config, **vars(run.outcome)} for run in rows]
    facts = provenance(clip=Source.of(path), input=flags.input, machine=machine, runs=told)
    name = f"work-precision-{clip.name}-{flags.input}"
    write_bytes(flags.out / f"{name}.json", strict_json(facts, indent=1).encode())
    where = "held-out training" if flags.held_out else "test"
    title = f"{clip.name}, {flags.input} frames: {where} frames"
    diagrams_figure(diagrams(rows, TrainConfig()), title).savefig(flags.out / f"{name}.png", dpi=150)


def wanted(flags: argparse.Namespace) -> Iterator[tuple[str, TrainConfig]]:
    for seed in range(flags.seeds):
        for knob, config in settings():
            if knob in flags.knobs and config.method in flags.methods and (seed == 0 or knob == "method"):
                yield knob, replace(config, seed=seed, hold_out=flags.held_out)


def folder(config: TrainConfig, flags: argparse.Namespace) -> RunFolder:
    name = f"{setting_of(config)}, {flags.input}, seed {config.seed}"
    return RunFolder(flags.out / "".join(letter if letter.isalnum() else "-" for letter in name))


def measured(path: Path, config: TrainConfig, truth: Phantom | None, flags: argparse.Namespace) -> Run:
    """Train, or take what is there, and measure against the frames that it was trained on."""
    run = folder(config, flags)
    sys.stderr.write(f"{run.path.name}\n")
    request = TrainRequest(clip_path=path, run_path=run.path, config=config, input=flags.input, resume=True)
    finished = next(event for event in run_training(request) if isinstance(event, Finished))
    frames = input_clip(run_clip(run.record()), run.record())
    return Run(config=config, input=flags.input, outcome=outcome(finished, frames, config, truth))


def show(runs: Sequence[Run]) -> None:
    """Means over the seeds, and half the distance of the extremes."""
    heads = "".join(f"{name:>18}" for name in COLUMNS)
    print(f"{'':44}seeds{heads}{'s, steps':>9}{'s in total':>9}{'MB':>8}{'Gaussians':>11}")
    for group in grouped(runs):
        cells = "".join(f"{spread(group, column, form):>18}" for column, form in COLUMNS.items())
        keys = ("seconds", "wall_seconds", "megabytes", "n_gaussians")
        seconds, wall, megabytes, count = (mean(group, key) for key in keys)
        name = group[0].setting
        print(f"{name:44}{len(group):5}{cells}{seconds:9.1f}{wall:9.1f}{megabytes:8.1f}{count:11.0f}")
    for diagram in diagrams(runs, TrainConfig()):
        front = ", ".join(
            f"{point.series} {point.setting} ({point.seconds:.0f} s)" for point in pareto_front(diagram)
        )
        print(f"front of {diagram.measure}: {front}")


def spread(group: Sequence[Run], column: str, form: str) -> str:
    values = [run.value(column) for run in group]
    half = f" ±{(max(values) - min(values)) / 2:{form}}" if len(group) > 1 else ""
    return f"{mean(group, column):{form}}{half}"


if __name__ == "__main__":
    main()
