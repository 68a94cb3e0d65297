"""A textured plane whose pictures are known in closed form: it rests or slides, as does the camera."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.clip import Clip, Frame

SIZE = (96, 80)
N_FRAMES = 12
FOCAL = 90.0
DISTANCE = 50.0


def plane_clip(
    slide: float = 0.0,
    circle: float = 0.0,
    lamp: float = 0.0,
    gloss: float = 0.0,
    noise: float = 0.0,
    masked: bool = False,
    has_depth: bool = True,
) -> Clip:
    """The plane slides to and fro by `slide` px, the camera circles by `circle` mm.

    `lamp` shades the picture differently in each frame by up to so much of its light; `gloss` adds as much
    white light in a spot that wanders over the picture; `noise` is in grey levels.
    """
    lens = Camera(FOCAL, FOCAL, 48.0, 40.0, *SIZE)

    def camera(index: int) -> Camera:
        turn = 2 * np.pi * index / N_FRAMES
        pose = np.eye(4)
        pose[:2, 3] += circle * np.cos(turn), circle * np.sin(turn)
        return lens.moved(pose)

    def read_frame(index: int) -> Frame:
        rng = np.random.default_rng(index)
        moved = slide * DISTANCE / FOCAL * np.sin(2.6 * np.pi * index / N_FRAMES)
        depth = np.full((SIZE[1], SIZE[0]), DISTANCE, np.float32)
        where = camera(index).unproject(depth)
        light = _albedo(where[..., 0] - moved, where[..., 1])
        across, down = np.meshgrid(np.linspace(-1, 1, SIZE[0]), np.linspace(-1, 1, SIZE[1]))
        turn = 2 * np.pi * index / N_FRAMES
        light = light * (1 + lamp * np.sin(turn + 2 * across))[..., None]
        spot = (across - np.cos(turn) / 2) ** 2 + (down - np.sin(turn) / 2) ** 2
        light = light + gloss * np.exp(-12 * spot)[..., None]
        grey = 255 * np.clip(light, 0, 1) ** (1 / 2.2) + noise * rng.standard_normal(light.shape)
        image = np.rint(np.clip(grey, 0, 255)).astype(np.uint8)
        mask = np.ones(depth.shape, bool)
        mask[:34, :40] = not masked
        return Frame(index, index / N_FRAMES, image, camera(index), mask, mask, depth if has_depth else None)

    return Clip(
        name="plane",
        path=Path("plane"),
        format="images",
        cameras=tuple(camera(index) for index in range(N_FRAMES)),
        read_frame=read_frame,
        read_image=lambda index: read_frame(index).image,
        labels=tuple(map(str, range(N_FRAMES))),
        has_depth=has_depth,
        unit="mm",
    )


def _albedo(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """(H, W, 3) linear RGB of pink tissue with waves of 4 to 9 mm in it, red everywhere above green."""
    rng = np.random.default_rng(5)
    waves = np.zeros_like(x)
    for angle, length, phase in zip(
        rng.uniform(0, np.pi, 12), rng.uniform(4, 9, 12), rng.uniform(0, 6.3, 12), strict=True
    ):
        waves += np.sin(2 * np.pi * (np.cos(angle) * x + np.sin(angle) * y) / length + phase) / 12
    return np.stack([0.45 + 0.1 * waves, 0.2 - 0.2 * waves, 0.17 - 0.1 * waves], axis=-1)
