"""What leaving a part out saves and costs: runs with and without it, side by side, on phantoms.

python -m tests.benchmarks.train_needs [PAIR ...] [--seeds N] [--iterations N]

See renderer.measuring.ablation for what the columns are. `vesselsplat report --parts left_out` does the
same, shorter.
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

from renderer.measuring.ablation import Side, ablation
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from renderer.train.config import Part, TrainConfig

CONFIG = TrainConfig(n_gaussians=8000, hold_out=True)
"""As many Gaussians a pixel as at 640x512 by default."""


@dataclass(frozen=True)
class Pair:
    """A kind of phantom, and the parts that are left out or kept there."""

    camera: Literal["fixed", "moving"]
    tissue: Literal["moving", "static"]
    parts: tuple[Part, ...]


PAIRS = {
    "deformation": Pair("moving", "static", ("deformation",)),
    "harmonics": Pair("fixed", "moving", ("harmonics",)),
    "everything": Pair("fixed", "static", ("harmonics", "deformation", "color_curves")),
    "color_curves": Pair("fixed", "static", ("color_curves",)),
    "lamp": Pair("moving", "static", ("harmonics",)),
    "controls": Pair("fixed", "moving", ("controls",)),
    "moments": Pair("fixed", "moving", ("moments",)),
    "tiles": Pair("fixed", "moving", ("tiles",)),
}
"""By name; `lamp`: harmonics beside colour curves, where the lamp moves with the camera."""
COLUMNS = ("milliseconds", "seconds", "megabytes", "psnr")


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
            rows.append(measured(PAIRS[name], seed, flags.iterations))
            show(name, str(seed), *rows[-1])
        if len(rows) > 1:
            show(name, "mean", *(mean(sides) for sides in zip(*rows, strict=True)))
        print(f"{'':14}left out: {', '.join(each.what for each in rows[0][0].omitted)}\n")


def measured(pair: Pair, seed: int, iterations: int) -> tuple[Side, Side]:
    """Without and with."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "phantom"
        write_phantom(path, PhantomParams(camera=pair.camera, tissue=pair.tissue, seed=seed))
        without = replace(CONFIG, iterations=iterations)
        first, second = ablation(open_clip(path), [without, replace(without, keep=pair.parts)])
        return first, second


def mean(sides: Sequence[Side]) -> Side:
    means = {name: float(np.mean([getattr(side, name) for side in sides])) for name in COLUMNS}
    return replace(sides[0], **means)


def show(name: str, seed: str, without: Side, kept: Side) -> None:
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
