"""How fast the CPU rasteriser is: forward and backward, in units of one numpy.exp over 10 million float32.

The scene is that of renderer.measuring.scattered. The unit is measured in the same process, single thread,
into a given array; rounds alternate, so that a busy machine slows both alike. "through torch" is forward and
backward of `renderer.rasterize.rasterize` with a loss on image, alpha and depth. With the word "busy" another
process keeps one core busy meanwhile. Without AVX-512 (NUMBA_CPU_NAME=haswell and its NUMBA_CPU_FEATURES) the
kernels take 1.2 times the CPU time at 50k: 13.5 + 20.0 ms of one thread for 11.4 + 16.6. Memory is what
a first picture of 50k adds to the peak of the process after its imports, kernels and scene included.
"""

from __future__ import annotations

import atexit
import os
import resource
import subprocess
import sys
from collections.abc import Callable
from time import perf_counter

import numpy as np
import torch

from renderer.camera import Camera
from renderer.measuring.scattered import scattered
from renderer.rasterize import rasterize
from renderer.rasterize.cpu import Rasterizer
from renderer.splats import Splats

SCENES = ((640, 512, 10_000), (640, 512, 50_000), (640, 512, 100_000), (1280, 1024, 50_000))
ROUNDS = 15


def measure(width: int, height: int, count: int) -> None:
    """Print one row."""
    splats, camera = scattered(width, height, count)
    values = np.random.default_rng(1).uniform(-8, 0, 10_000_000).astype(np.float32)
    out = np.empty_like(values)
    rasterizer = Rasterizer(width, height)
    rasterizer.adjoint[:4] = np.random.default_rng(2).normal(size=rasterizer.adjoint[:4].shape)
    by_torch = through_torch(splats, camera)
    taken = np.empty((ROUNDS + 2, 4))
    for row in taken:
        start = perf_counter()
        np.exp(values, out=out)
        unit = perf_counter()
        entries = rasterizer.forward(splats, camera)
        drawn = perf_counter()
        rasterizer.backward(splats)
        kernels = perf_counter()
        by_torch()
        row[:] = unit - start, drawn - unit, kernels - drawn, perf_counter() - kernels
    unit, forward, backward, face = 1000 * np.median(taken[2:], axis=0)
    ratio = (forward + backward) / unit
    size = f"{width} x {height}"
    sys.stdout.write(
        f"{size:>12}{count:9}{entries:9}{unit:9.2f}{forward:9.2f}{backward:9.2f}{ratio:8.2f}"
        f"{1e6 * (forward + backward) / entries:13.0f}{face:15.2f}{face / unit:8.2f}\n"
    )


def through_torch(splats: Splats, camera: Camera) -> Callable[[], None]:
    """Forward and backward through autograd."""
    names = "means", "quats", "scales", "opacities", "colors"
    inputs = [torch.from_numpy(getattr(splats, name).copy()).requires_grad_() for name in names]
    weights = torch.randn(camera.height, camera.width, 3, generator=torch.Generator().manual_seed(3))

    def step() -> None:
        drawn = rasterize(*inputs, camera, backend="cpu")
        loss = (drawn.image * weights).sum() + drawn.alpha.sum() + drawn.depth.sum()
        torch.autograd.grad(loss, inputs)

    return step


def busy_core() -> None:
    """Another process that counts for as long as this one lives."""
    other = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    atexit.register(other.kill)


def memory_of_a_picture() -> float:
    """MiB, of the first in this process."""
    before = peak_mib()
    splats, camera = scattered(640, 512, 50_000)
    rasterizer = Rasterizer(640, 512)
    rasterizer.forward(splats, camera)
    rasterizer.backward(splats)
    return peak_mib() - before


def peak_mib() -> float:
    """Of this process so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main() -> None:
    if "busy" in sys.argv[1:]:
        busy_core()
    sys.stdout.write(f"memory of a picture of 50k: {memory_of_a_picture():.0f} MiB more than the imports\n")
    sys.stdout.write(f"load {os.getloadavg()[0]:.1f} of {os.cpu_count()} cores\n")
    sys.stdout.write(
        f"{'size':>12}{'splats':>9}{'entries':>9}{'unit ms':>9}{'forward':>9}{'backward':>9}{'units':>8}"
        f"{'ns an entry':>13}{'through torch':>15}{'units':>8}\n"
    )
    for each in SCENES:
        measure(*each)


if __name__ == "__main__":
    main()
