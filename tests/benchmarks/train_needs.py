"""What leaving a part out saves and costs: runs with and without it, side by side, on phantoms.

python -m tests.benchmarks.train_needs [PAIR ...] [--seeds N] [--iterations N]

PSNR is of training frames that are held out of the fit. Memory is that of the model's numbers with their two
moments. Seconds are of training steps, in turns; on a machine with other load only their ratio means much.
"""

from __future__ import annotations

import argparse
import os
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
from renderer.train.trainer import train

CONFIG = TrainConfig(n_gaussians=8000, hold_out=True)
"""As many Gaussians a pixel as at 640x512 by default."""


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
    print(f"{'kept':14}seed  seconds without, kept, ratio   MB without, kept   PSNR dB without, kept, gain")
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
        configs = (replace(config, iterations=iterations) for config in (pair.without, pair.kept))
        without, kept = (measured(clip, config) for config in configs)
    return without, kept


def measured(clip: Clip, config: TrainConfig) -> Run:
    events = list(train(clip, config))
    started, finished = events[0], events[-1]
    assert isinstance(started, Started)
    assert isinstance(finished, Finished)
    numbers = sum(value.nbytes for value in finished.model.arrays().values())
    psnr = next(event.psnr for event in events if isinstance(event, Evaluated))
    left_out = ", ".join(omission.what for omission in (*started.omitted, *finished.omitted))
    return Run(finished.seconds, 3 * numbers / 1e6, psnr, left_out)


def mean(runs: Sequence[Run]) -> Run:
    seconds, megabytes, psnr = (
        np.mean([getattr(run, name) for run in runs]) for name in ("seconds", "megabytes", "psnr")
    )
    return Run(float(seconds), float(megabytes), float(psnr), "")


def show(name: str, seed: str, without: Run, kept: Run) -> None:
    print(
        f"{name:14}{seed:>4} {without.seconds:9.1f} {kept.seconds:9.1f} {kept.seconds / without.seconds:6.2f}"
        f" {without.megabytes:12.1f} {kept.megabytes:6.1f}"
        f" {without.psnr:14.2f} {kept.psnr:6.2f} {kept.psnr - without.psnr:+6.2f}",
        flush=True,
    )


if __name__ == "__main__":
    main()
