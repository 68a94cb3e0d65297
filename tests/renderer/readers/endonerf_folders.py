"""Frames as EndoNeRF folders hold them."""

from __future__ import annotations

from renderer.camera import Camera
from renderer.clip import Frame
from tests.renderer.small_clip import small_frames

WIDTH, HEIGHT = 40, 32
LENS = Camera(35.0, 35.0, WIDTH / 2, HEIGHT / 2, WIDTH, HEIGHT)


def make_frames(angle: float = 0.0) -> list[Frame]:
    return small_frames(LENS, angle)
