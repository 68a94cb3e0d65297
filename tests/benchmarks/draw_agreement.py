"""How far OpenGL and the CPU rasteriser are from the float64 reference on a trained run, and the bars.

python -m tests.benchmarks.draw_agreement RUN [FRAME ...]
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.runs.run_folder import RunFolder
from renderer.draw.context import renderer_name, standalone_context
from renderer.draw.offscreen import render_offscreen
from renderer.gaussians import DynamicGaussians
from renderer.measuring.raster_accuracy import exact
from renderer.near_plane import near_plane
from renderer.rasterize.cpu import render

BARS = {"gl float": 75.0, "gl half": 60.0, "numba": 75.0}
"""Least PSNR in dB."""
WIDEST = 1.0
"""Grey levels that all but one value in a thousand stay within."""


def main(run_path: Path, frames: list[int]) -> None:
    run = RunFolder(run_path)
    record = run.record()
    model = DynamicGaussians.load(run.model_path)
    context = standalone_context()
    print(f"OpenGL: {renderer_name(context)}; {len(model)} Gaussians, {record.clip.frames} frames")
    print("frame  renderer       PSNR dB    p99.9     max (grey levels)   ms   reference s")
    for index in frames or (1, record.clip.frames // 2):
        camera = record.cameras[index]
        splats = model.at(record.time(index)).seen_from(camera.position)
        near = near_plane(model, camera)
        began = time.perf_counter()
        want = exact(splats, camera, near)
        seconds = time.perf_counter() - began
        renderers: dict[str, Callable[[], NDArray[np.float32]]] = {
            "gl float": partial(render_offscreen, context, splats, camera, precision="float", near=near),
            "gl half": partial(render_offscreen, context, splats, camera, precision="half", near=near),
            "numba": lambda s=splats, c=camera, n=near: render(s, c, near=n).image,  # type: ignore[misc]
        }
        for name, draw in renderers.items():
            draw()
            began = time.perf_counter()
            got = draw()
            report(index, name, got, want, (time.perf_counter() - began) * 1e3, seconds)


def report(
    index: int,
    name: str,
    got: NDArray[np.float32],
    want: NDArray[np.float64],
    milliseconds: float,
    seconds: float,
) -> None:
    levels = 255 * np.abs(got - want)
    psnr = -10 * np.log10((levels**2).mean() / 255**2)
    widest = np.quantile(levels, 0.999)
    met = "met" if psnr >= BARS[name] and widest <= WIDEST else "MISSED"
    print(
        f"{index:5d}  {name:12s} {psnr:9.1f} {widest:8.4f} {levels.max():8.3f} {milliseconds:15.1f}"
        f" {seconds:13.1f}   bar of {BARS[name]:g} dB {met}",
        flush=True,
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]), [int(value) for value in sys.argv[2:]])
