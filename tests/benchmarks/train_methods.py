"""`python -m tests.benchmarks.train_methods [CLIP] [--steps N] [--seeds N ...]`: the methods side by side.

Each method is trained with every seed for the steps of the published schedules, 3000, with as many Gaussians
a pixel as by default at 640x512, and measured on the held-out frames; without a clip, the phantom is used.
Means are printed with the standard deviation over the seeds, and the median time, of the steps alone and from
the first frame read to the model written. Kernels are compiled before.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np

from app.report.bench import PHANTOM
from app.report.runs import schedule
from app.runs.train_run import TrainRequest, run_training
from renderer.measuring.training_accuracy import Outcome, outcome
from renderer.phantom import write_phantom
from renderer.sources import open_clip
from renderer.train.config import Method, TrainConfig
from renderer.train.events import Finished

WARM_UP = 20
"""Steps."""


def main() -> None:
    """A line for each method."""
    parser = argparse.ArgumentParser()
    parser.add_argument("clip", type=Path, nargs="?")
    parser.add_argument("--steps", type=int, default=3000)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        path = given.clip or Path(scratch) / "phantom"
        if given.clip is None:
            write_phantom(path, PHANTOM)
        for method in get_args(Method):
            config = replace(schedule(open_clip(path), method), iterations=given.steps)
            _trained(path, replace(config, iterations=WARM_UP))
            print(
                _line(method, [_trained(path, replace(config, seed=seed)) for seed in given.seeds]),
                flush=True,
            )


def _trained(path: Path, config: TrainConfig) -> Outcome:
    with tempfile.TemporaryDirectory() as scratch:
        request = TrainRequest(clip_path=path, run_path=Path(scratch) / "run", config=config)
        *_, last = run_training(request)
        assert isinstance(last, Finished)
        return outcome(last, open_clip(path), config)


def _line(method: Method, found: list[Outcome]) -> str:
    def spread(values: list[float]) -> str:
        return f"{np.mean(values):7.3f} +-{np.std(values, ddof=1) if len(values) > 1 else 0:.3f}"

    steps, wall = (
        float(np.median(times))
        for times in ([one.seconds for one in found], [one.wall_seconds for one in found])
    )
    psnr, depth = spread([one.psnr for one in found]), spread([one.depth_rmse for one in found])
    return f"{method:12} {psnr} dB  depth {depth}  {steps:.1f} s training, {wall:.1f} s in total"


if __name__ == "__main__":
    main()
