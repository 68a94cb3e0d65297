"""A small scene with known motion: a textured sheet that slides and comes nearer, depth exact."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from renderer.camera import Camera
from renderer.clip import Clip, Frame
from renderer.gaussians import DynamicGaussians
from renderer.rasterize.cpu import render
from renderer.splats import Splats
from renderer.train.config import TrainConfig
from renderer.train.events import Evaluated, Finished, Started
from renderer.train.needs import Needs, decide
from renderer.train.trainer import split
from renderer.train.training import train

SIZE = (48, 32)
N_FRAMES = 12


def moving_sheet(unit: float = 1.0, shift: float = 6.0) -> Clip:
    """A textured sheet that slides and comes nearer: frames drawn from known Gaussians, depth exact."""
    camera = Camera(50.0, 50.0, 24.0, 16.0, *SIZE)
    rng = np.random.default_rng(3)
    grid = np.stack(np.meshgrid(np.linspace(-32, 32, 34), np.linspace(-22, 22, 24)), -1).reshape(-1, 2)
    colors = rng.uniform(0.1, 0.9, (len(grid), 3)).astype(np.float32)

    def read_frame(index: int) -> Frame:
        time = index / N_FRAMES
        z = (50.0 - 5.0 * np.sin(2 * np.pi * time)) * unit
        means = np.column_stack(
            [(grid[:, 0] + shift * time) * unit, grid[:, 1] * unit, np.full(len(grid), z)]
        )
        splats = Splats(
            means.astype(np.float32),
            np.tile(np.array([1, 0, 0, 0], np.float32), (len(grid), 1)),
            np.full((len(grid), 3), 1.2 * unit, np.float32),
            np.full(len(grid), 0.95, np.float32),
            colors,
        )
        image = np.rint(np.clip(render(splats, camera).image, 0, 1) * 255).astype(np.uint8)
        mask = np.ones(image.shape[:2], bool)
        mask[:8, :10] = False
        return Frame(index, time, image, camera, mask, mask, np.full(mask.shape, z, np.float32))

    return Clip(
        name="sheet",
        path=Path("sheet"),
        format="images",
        cameras=(camera,) * N_FRAMES,
        read_frame=read_frame,
        read_image=lambda index: read_frame(index).image,
        labels=tuple(map(str, range(N_FRAMES))),
        has_depth=True,
        unit="mm",
    )


def finished(clip: Clip, config: TrainConfig, **arguments: Any) -> tuple[DynamicGaussians, float]:
    """The model that a training gives, and its PSNR on frames that it did not see; NaN without such."""
    events = list(train(clip, config, **arguments))
    assert isinstance(events[0], Started)
    assert isinstance(events[-1], Finished)
    held_out = [event.psnr for event in events if isinstance(event, Evaluated)]
    return events[-1].model, held_out[-1] if held_out else float("nan")


def same_bytes(a: DynamicGaussians, b: DynamicGaussians) -> bool:
    return all(
        x.tobytes() == y.tobytes() for x, y in zip(a.arrays().values(), b.arrays().values(), strict=True)
    )


SMALL = TrainConfig(
    iterations=300, n_gaussians=500, n_controls=7, node_columns=5, checkpoint_every=40, hold_out=True
)


def needs_of(clip: Clip, config: TrainConfig) -> Needs:
    """As training decides them."""
    fit, _ = split(clip, config)
    frames = [clip.read_frame(index) for index in fit]
    has_depth = any(frame.depth_mask.any() for frame in frames)
    return decide(clip, frames, config, follow=frames if has_depth else None)
