"""A few small frames with known depth, tools and cameras, for the tests of what reads them back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.clip import ClipError, Frame
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.sources import open_clip

WIDTH, HEIGHT, COUNT = 64, 48, 10
LENS = Camera(55.0, 55.0, 29.0, 26.5, WIDTH, HEIGHT)


def moved(lens: Camera, angle: float) -> Camera:
    """`lens` turned about the vertical by `angle` in radians, and moved along."""
    matrix = np.eye(4)
    matrix[0, :3] = np.cos(angle), 0, np.sin(angle)
    matrix[2, :3] = -np.sin(angle), 0, np.cos(angle)
    matrix[:3, 3] = 40 * angle, -20 * angle, 10 * angle
    return lens.moved(matrix)


def small_frames(lens: Camera = LENS, angle: float = 0.0, count: int = COUNT) -> list[Frame]:
    """Reddish tissue with depth 40 to 90; a grey tool without covers a quarter. Turned by `angle` a frame."""
    rng = np.random.default_rng(3)
    shape = lens.height, lens.width
    frames = []
    for index in range(count):
        tool = np.zeros(shape, dtype=bool)
        left = 2 * index
        tool[shape[0] // 4 : 3 * shape[0] // 4, left : left + shape[1] // 2] = True
        red = rng.integers(0, 40, (*shape, 3)) + np.array([180, 90, 80])
        grey = rng.integers(90, 120, (*shape, 1)).repeat(3, axis=2)
        image = np.where(tool[:, :, None], grey, red).astype(np.uint8)
        depth = np.where(tool, 0, rng.uniform(40, 90, shape)).astype(np.float32)
        frames.append(Frame(index, index / count, image, moved(lens, angle * index), ~tool, ~tool, depth))
    return frames


def points_of(frame: Frame) -> np.ndarray:
    """World points (N, 3) behind the pixels with depth."""
    assert frame.depth is not None
    return frame.camera.unproject(frame.depth)[frame.depth > 0]


def refusal(path: Path, options: ClipOptions = DEFAULTS) -> str:
    """The one line with which a clip, or a frame of it, is refused."""
    with pytest.raises(ClipError) as caught:
        read_all(path, options)
    line = str(caught.value)
    assert "\n" not in line
    assert str(path) in line
    return line


def read_all(path: Path, options: ClipOptions = DEFAULTS) -> list[Frame]:
    clip = open_clip(path, options)
    return [clip.read_frame(index) for index in range(len(clip))]
