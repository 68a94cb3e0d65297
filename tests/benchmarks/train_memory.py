"""Memory and seconds against frames.

python -m tests.benchmarks.train_memory [--size 640x512] [--frames 250 1000 4000] [--camera moving]

Each clip has the frames of one phantom over and over, by hard links; each training is a process of its own,
so that its peak is its own. The frames themselves are held up to a bound; the model grows with them, by the
control values of its curves, and beyond the length of a window by other windows, of which one is held.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from renderer.phantom import PhantomParams, write_phantom

ORIGINALS = 16
"""Frames of the phantom."""


def main() -> None:
    """Prints a table in MB of 10^6 bytes."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--size", default="640x512")
    parser.add_argument("--frames", type=int, nargs="*", default=[250, 500, 1000, 2000, 4000])
    parser.add_argument("--iterations", type=int, default=60)
    parser.add_argument("--method", default="vesselsplat")
    parser.add_argument("--camera", choices=("fixed", "moving"), default="fixed")
    given = parser.parse_args()
    width, height = map(int, given.size.split("x"))
    print("frames   peak MB   told MB   model MB   wall s")
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as scratch:
        phantom = Path(scratch) / "phantom"
        shown = PhantomParams(n_frames=ORIGINALS, width=width, height=height, seed=3, camera=given.camera)
        write_phantom(phantom, shown)
        for count in given.frames:
            clip, run = Path(scratch) / f"clip-{count}", Path(scratch) / f"run-{count}"
            repeated(phantom, clip, count)
            flags = ["--iterations", str(given.iterations), "--method", given.method]
            peak, told, seconds = _trained(clip, run, flags)
            stored = (run / "model.safetensors").stat().st_size
            print(f"{count:6d} {peak / 1e6:9.0f} {told:9.0f} {stored / 1e6:10.0f} {seconds:8.0f}", flush=True)
            shutil.rmtree(run)


def repeated(phantom: Path, clip: Path, count: int) -> None:
    """A clip of `count` frames in the layout of EndoNeRF, of those of another, forwards and backwards."""
    order = [*range(ORIGINALS), *reversed(range(ORIGINALS))]
    for folder in (path for path in phantom.iterdir() if path.is_dir()):
        (clip / folder.name).mkdir(parents=True)
        files = sorted(folder.iterdir())
        for index in range(count):
            source = files[order[index % len(order)]]
            os.link(source, clip / folder.name / f"{index:06d}{source.suffix}")
    poses = np.load(phantom / "poses_bounds.npy")
    np.save(clip / "poses_bounds.npy", poses[[order[index % len(order)] for index in range(count)]])


def _trained(clip: Path, run: Path, flags: list[str]) -> tuple[int, float, float]:
    """Peak of resident memory in bytes, what was told of it before in MB, and seconds."""
    command = [sys.executable, "-m", "app", "train", str(clip), "--run", str(run)]
    began = time.perf_counter()
    child = subprocess.Popen([*command, *flags], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    assert child.stderr is not None
    said = child.stderr.read()
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise SystemExit(said)
    found = re.search(r"up to ([\d.]+) (GB|MB) of memory", said)
    assert found is not None
    told = float(found[1]) * (1000 if found[2] == "GB" else 1)
    return used.ru_maxrss * 1024, told, time.perf_counter() - began


if __name__ == "__main__":
    main()
