"""What leaving a part out saves and costs: runs with and without it, side by side, on phantoms.

python -m tests.benchmarks.train_needs [PAIR ...] [--seeds N] [--iterations N]

PSNR is of training frames that are held out of the fit. Memory is that of the model's numbers with their two
moments. A step's time is the median over steps at full size that the two models take in turns, from the
middle of the run on; seconds are those of the whole runs, one after the other, and suffer from other load.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

import numpy as np

from renderer.clip import Clip
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from renderer.train.events import Evaluated, Finished, Started
from renderer.train.frames import train_frame
from renderer.train.initialize import scene_size
from renderer.train.methods import recipe_for
from renderer.train.model import TrainModel
from renderer.train.needs import decide
from renderer.train.trainer import split, train

CONFIG = TrainConfig(n_gaussians=8000, hold_out=True)
"""As many Gaussians a pixel as at 640x512 by default."""
TIMED_STEPS = 120
"""Of each model; those before every frame was seen once do not count."""


@dataclass(frozen=True, kw_only=True)
class Pair:
    """A kind of phantom, and the part that is left out or kept there."""

    camera: Literal["fixed", "moving"]
    tissue: Literal["moving", "static"]
    without: TrainConfig
    kept: TrainConfig


def _as_needed(
    camera: Literal["fixed", "moving"], tissue: Literal["moving", "static"], **kept: object
) -> Pair:
    return Pair(camera=camera, tissue=tissue, without=CONFIG, kept=replace(CONFIG, **kept))  # type: ignore[arg-type]


PAIRS = {
    "deformation": _as_needed("moving", "static", keep=("deformation",)),
    "harmonics": _as_needed("fixed", "moving", keep=("harmonics",)),
    "everything": _as_needed("fixed", "static", keep=("harmonics", "deformation", "color_curves")),
    "color_curves": _as_needed("fixed", "static", keep=("color_curves",)),
    "lamp": _as_needed("moving", "static", keep=("harmonics",)),
    "controls": _as_needed("fixed", "moving", keep=("controls",)),
    "moments": _as_needed("fixed", "moving", keep=("moments",)),
    "tiles": _as_needed("fixed", "moving", keep=("tiles",)),
}
"""By name; `lamp`: harmonics beside colour curves, where the lamp moves with the camera."""


@dataclass(frozen=True)
class Run:
    milliseconds: float
    """A step."""
    seconds: float
    megabytes: float
    psnr: float
    left_out: str


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("pairs", nargs="*", default=list(PAIRS), choices=[*PAIRS, []])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--iterations", type=int, default=1200)
    flags = parser.parse_args()
    print(f"load {os.getloadavg()[0]:.1f}, {flags.iterations} iterations, 320x256, 24 frames")
    print(
        f"{'kept':14}seed  ms a step: out, in, ratio   s: out, in      MB: out, in   PSNR dB: out, in, gain"
    )
    for name in flags.pairs:
        rows = []
        for seed in range(flags.seeds):
            rows.append(compared(PAIRS[name], seed, flags.iterations))
            show(name, str(seed), *rows[-1])
        if len(rows) > 1:
            show(name, "mean", *(mean(runs) for runs in zip(*rows, strict=True)))
        print(f"{'':14}left out: {rows[0][0].left_out}\n")


def compared(pair: Pair, seed: int, iterations: int) -> tuple[Run, Run]:
    """Without and with."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "phantom"
        write_phantom(path, PhantomParams(camera=pair.camera, tissue=pair.tissue, seed=seed))
        clip = open_clip(path)
        configs = [replace(config, iterations=iterations) for config in (pair.without, pair.kept)]
        times = step_times(clip, configs)
        without, kept = (measured(clip, *each) for each in zip(configs, times, strict=True))
    return without, kept


def step_times(clip: Clip, configs: Sequence[TrainConfig]) -> list[float]:
    """Median milliseconds of a step of each configuration, taken in turns."""
    models, frames = [], [clip.read_frame(index) for index in split(clip, configs[0])[0]]
    size = scene_size(frames)
    for config in configs:
        recipe = recipe_for(config, decide(clip, frames, config))
        raw = recipe.initialize(frames)
        models.append(TrainModel(raw, recipe.make_trainer(raw, frames, size), recipe, size))
    views, first = [train_frame(frame) for frame in frames], configs[0].iterations // 2
    laps = np.zeros((TIMED_STEPS, len(models)))
    for step, place in np.ndindex(laps.shape):
        began = time.perf_counter()
        models[place].step(views[step % len(views)], min(first + step, configs[0].iterations - 1))
        laps[step, place] = 1000 * (time.perf_counter() - began)
    return [float(lap) for lap in np.median(laps[len(views) :], axis=0)]


def measured(clip: Clip, config: TrainConfig, milliseconds: float) -> Run:
    events = list(train(clip, config))
    started, finished = events[0], events[-1]
    assert isinstance(started, Started)
    assert isinstance(finished, Finished)
    numbers = sum(value.nbytes for value in finished.model.arrays().values())
    psnr = next(event.psnr for event in events if isinstance(event, Evaluated))
    left_out = ", ".join(omission.what for omission in (*started.omitted, *finished.omitted))
    return Run(milliseconds, finished.seconds, 3 * numbers / 1e6, psnr, left_out)


def mean(runs: Sequence[Run]) -> Run:
    columns = ("milliseconds", "seconds", "megabytes", "psnr")
    return Run(*(float(np.mean([getattr(run, name) for run in runs])) for name in columns), runs[0].left_out)


def show(name: str, seed: str, without: Run, kept: Run) -> None:
    ratio = kept.milliseconds / without.milliseconds
    print(
        f"{name:14}{seed:>4}"
        f" {without.milliseconds:9.2f} {kept.milliseconds:7.2f} {ratio:6.2f}"
        f" {without.seconds:9.1f} {kept.seconds:6.1f}"
        f" {without.megabytes:8.1f} {kept.megabytes:6.1f}"
        f" {without.psnr:9.2f} {kept.psnr:6.2f} {kept.psnr - without.psnr:+6.2f}",
        flush=True,
    )


if __name__ == "__main__":
    main()
