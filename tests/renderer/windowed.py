"""Models in windows, put together from others."""

from __future__ import annotations

from functools import partial

from renderer.gaussians import DynamicGaussians
from renderer.train.window_files import in_windows
from renderer.train.windows import Window


def windowed(count: int, *parts: tuple[int, int, DynamicGaussians]) -> DynamicGaussians:
    """Of a clip of `count` frames; each part with its first and its last frame."""
    windows = [Window(first, last) for first, last, _ in parts]
    return in_windows(count, windows, [partial(_same, model) for _, _, model in parts])


def _same(model: DynamicGaussians) -> DynamicGaussians:
    return model
