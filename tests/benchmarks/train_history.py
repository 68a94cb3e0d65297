"""`python -m tests.benchmarks.train_history CLIP [--note TEXT] [--keep PART ...]`: quality over changes.

The default method is trained with three seeds, 3000 steps, and measured on the clip's test frames; a line is
added to train_history.csv beside this file, and the whole table printed with what changed from line to line.
Seeds of one tree differ by a standard deviation of .07 dB on the pulling clip: a change below that says
nothing of one seed, and a mean of three moves by .04 without any cause but other rounding.
"""

from __future__ import annotations

import argparse
import csv
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from app.runs.train_run import TrainRequest, run_training
from renderer.measuring.training_accuracy import outcome
from renderer.sources import open_clip
from renderer.train.config import Part, TrainConfig
from renderer.train.events import Finished

HISTORY = Path(__file__).with_name("train_history.csv")
COLUMNS = ("tree", "clip", "note", "seeds", "psnr", "depth", "train_seconds", "wall_seconds")
Row = dict[str, str]


def main() -> None:
    """Adds a line, and prints all."""
    parser = argparse.ArgumentParser()
    parser.add_argument("clip", type=Path)
    parser.add_argument("--note", default="")
    parser.add_argument("--keep", nargs="*", default=())
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    given = parser.parse_args()
    measured = [_measured(given.clip, seed, tuple(given.keep)) for seed in given.seeds]
    columns = [_joined(values) for values in zip(*measured, strict=True)]
    seeds = " ".join(map(str, given.seeds))
    rows = [
        *_rows(),
        dict(zip(COLUMNS, (_tree(), given.clip.name, given.note, seeds, *columns), strict=True)),
    ]
    with HISTORY.open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    for line in lines([row for row in rows if row["clip"] == given.clip.name]):
        print(line)


def lines(rows: Sequence[Row]) -> list[str]:
    """A line for each row: mean and spread of PSNR, and the change since the row before of as many seeds."""
    told, before = [], dict[str, float]()
    for row in rows:
        values = [float(value) for value in row["psnr"].split()]
        mean, spread = float(np.mean(values)), float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
        change = f"{mean - before[row['seeds']]:+.3f}" if row["seeds"] in before else "     "
        before[row["seeds"]] = mean
        told.append(
            f"{row['tree']:9} {mean:.3f} dB +-{spread:.3f} {change:>7}  {row['psnr']:24} {row['note']}"
        )
    return told


def _measured(path: Path, seed: int, keep: tuple[Part, ...]) -> tuple[float, float, float, float]:
    """PSNR in dB, depth error in the clip's unit, seconds of steps and in all."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "run"
        config = TrainConfig(seed=seed, keep=keep)
        *_, last = run_training(TrainRequest(clip_path=path, run_path=folder, config=config))
        assert isinstance(last, Finished)
        found = outcome(last, open_clip(path), config)
        return found.psnr, found.depth_rmse, found.seconds, found.wall_seconds


def _joined(values: Sequence[float]) -> str:
    return " ".join(f"{value:.3f}" for value in values)


def _rows() -> list[Row]:
    if not HISTORY.exists():
        return []
    with HISTORY.open(newline="") as file:
        return list(csv.DictReader(file))


def _tree() -> str:
    """The commit, with a plus where files have been changed since."""
    words = ["git", "describe", "--always", "--dirty=+"]
    done = subprocess.run(words, cwd=HISTORY.parent, capture_output=True, text=True, check=True)
    return done.stdout.strip()


if __name__ == "__main__":
    main()
