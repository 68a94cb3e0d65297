"""How far OpenGL and the CPU rasteriser are from the float64 reference on a trained run.

python -m tests.benchmarks.draw_agreement RUN [FRAME ...]
"""

from __future__ import annotations

import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from app.run_folder import RunFolder
from renderer.draw.context import renderer_name, standalone_context
from renderer.draw.offscreen import render_offscreen
from renderer.gaussians import DynamicGaussians
from renderer.near_plane import near_plane
from renderer.rasterize.cpu import render
from renderer.rasterize.reference import rasterize_reference

Image = NDArray[np.float64]


def main(run_path: Path, frames: list[int]) -> None:
    run = RunFolder(run_path)
    record = run.record()
    model = DynamicGaussians.load(run.model_path)
    context = standalone_context()
    print(f"OpenGL: {renderer_name(context)}; {len(model)} Gaussians, {record.clip.frames} frames")
    print("frame  renderer       PSNR dB   p99.9     max (grey levels)   ms")
    for index in frames or (1, 33):
        camera = record.camera(index)
        splats = model.at(record.time(index)).seen_from(camera.position)
        near = near_plane(model, camera)
        tensors = [
            torch.from_numpy(array)
            for array in (splats.means, splats.quats, splats.scales, splats.opacities, splats.colors)
        ]
        with torch.no_grad():
            want = rasterize_reference(*tensors, camera, near=near).image.numpy()
        renderers = {
            "gl float": partial(render_offscreen, context, precision="float"),
            "gl half": partial(render_offscreen, context, precision="half"),
            "numba": lambda *arguments, **names: render(*arguments, **names).image,
        }
        for name, draw in renderers.items():
            draw(splats, camera, near=near)
            began = time.perf_counter()
            got = draw(splats, camera, near=near)
            report(index, name, got.astype(np.float64), want, (time.perf_counter() - began) * 1e3)


def report(index: int, name: str, got: Image, want: Image, milliseconds: float) -> None:
    error = np.abs(got - want)
    psnr = -10 * np.log10((error**2).mean())
    levels = error * 255
    print(
        f"{index:5d}  {name:12s} {psnr:8.1f} {np.percentile(levels, 99.9):8.4f} {levels.max():8.3f}"
        f" {milliseconds:22.1f}"
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]), [int(value) for value in sys.argv[2:]])
