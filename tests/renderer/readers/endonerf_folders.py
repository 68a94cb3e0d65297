"""Frames as EndoNeRF folders hold them, and the line with which a folder is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.clip import ClipError, Frame
from renderer.readers.clip_options import ClipOptions
from renderer.readers.endonerf import open_endonerf

WIDTH, HEIGHT, COUNT = 40, 32, 10


def turned_camera(angle: float) -> Camera:
    matrix = np.eye(4)
    matrix[0, :3] = np.cos(angle), 0, np.sin(angle)
    matrix[2, :3] = -np.sin(angle), 0, np.cos(angle)
    matrix[:3, 3] = 3 * angle, -2 * angle, angle
    return Camera(35.0, 35.0, WIDTH / 2, HEIGHT / 2, WIDTH, HEIGHT, matrix)


def make_frames(angle: float = 0.0) -> list[Frame]:
    """Reddish tissue with depth, a grey tool without; the tool covers a quarter of the picture."""
    rng = np.random.default_rng(3)
    frames = []
    for index in range(COUNT):
        tool = np.zeros((HEIGHT, WIDTH), dtype=bool)
        tool[8:24, 2 * index : 2 * index + 20] = True
        red = rng.integers(0, 40, (HEIGHT, WIDTH, 3)) + np.array([180, 90, 80])
        grey = rng.integers(90, 120, (HEIGHT, WIDTH, 1)).repeat(3, axis=2)
        image = np.where(tool[:, :, None], grey, red).astype(np.uint8)
        depth = np.where(tool, 0, rng.uniform(40, 90, tool.shape)).astype(np.float32)
        camera = turned_camera(angle * index)
        frames.append(Frame(index, index / COUNT, image, camera, ~tool, ~tool, depth))
    return frames


def read_all(path: Path, options: ClipOptions) -> None:
    clip = open_endonerf(path, options)
    for index in range(len(clip)):
        clip.read_frame(index)


def refusal(path: Path, options: ClipOptions | None = None) -> str:
    """The one line with which the folder is refused."""
    with pytest.raises(ClipError) as caught:
        read_all(path, options or ClipOptions())
    line = str(caught.value)
    assert "\n" not in line
    assert path.name in line
    return line
