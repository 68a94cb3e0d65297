"""Small gaps of a view that are closed, against the formula in float64 pixel by pixel."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np

from renderer.camera import FloatArray
from renderer.closing import GONE, WHOLE, closed
from renderer.measuring.stability.row import Row, worst
from renderer.rasterize.rendered import Rendered

View = tuple[FloatArray, FloatArray, int]
"""Image (H, W, 3), alpha (H, W) and radius."""
BAR: Final = 0.002
"""Grey levels: sums over a window lose some of float32."""


def _scattered(height: int, width: int, radius: int, share: float = 0.7) -> View:
    """Some of the pixels, of any alpha and colour; a corner is empty."""
    rng = np.random.default_rng(4)
    alpha = rng.random((height, width)) * (rng.random((height, width)) < share)
    alpha[: height // 3, width // 2 :] = 0
    return rng.random((height, width, 3)) * alpha[..., None], alpha, radius


def _even(alpha: float) -> View:
    filled = np.full((40, 60), alpha)
    return np.linspace(0, 1, 60)[:, None] * np.ones(3) * filled[..., None], filled, 5


def _alternating() -> View:
    """Pixels that are opaque and such that are empty, half of each: the steepest place of an edge."""
    alpha = np.indices((150, 150)).sum(axis=0) % 2 * 1.0
    return alpha[..., None] * np.array([0.9, 0.5, 0.1]), alpha, 3


def _glaring() -> View:
    """Colours far beyond those of a screen beside ordinary ones, under a running sum."""
    image, alpha, radius = _scattered(60, 200, 4)
    image[:, 20:24] *= 1e3
    return image, alpha, radius


SCENES: Final[dict[str, Callable[[], View]]] = {
    "scattered, three tiles a side": lambda: _scattered(300, 290, 6),
    "a window larger than the image": lambda: _scattered(30, 45, 64),
    "one pixel": lambda: _scattered(1, 1, 3, 1.0),
    "one row": lambda: _scattered(1, 400, 9),
    "empty": lambda: _even(0.0),
    "opaque": lambda: _even(1.0),
    "as faint as what is left out": lambda: _even(GONE),
    "hardly there": lambda: _even(1e-30),
    "every other pixel": _alternating,
}


def rows() -> Iterator[Row]:
    """The largest error of each view, its alpha in 255 levels, too."""
    for name, make in SCENES.items():
        yield Row("closed gaps", name, error(*make()), BAR, "grey levels")
    yield Row("closed gaps", "colours 1000 times too bright", error(*_glaring()) / 1e3, BAR, "grey levels")


def error(image: FloatArray, alpha: FloatArray, radius: int) -> float:
    """Grey levels."""
    seen, left = image.astype(np.float32), alpha.astype(np.float32)
    got = closed(Rendered(seen, left, np.zeros_like(left)), radius)
    wanted, wanted_alpha = literal(seen.astype(np.float64), left.astype(np.float64), radius)
    pairs = (got.image, wanted), (got.alpha, wanted_alpha)
    return 255 * worst(np.abs(one - other).max() for one, other in pairs)


def literal(image: FloatArray, alpha: FloatArray, radius: int) -> tuple[FloatArray, FloatArray]:
    """Image (H, W, 3) and alpha (H, W) by the formula of renderer/closing.py."""
    closed_image, closed_alpha = np.zeros_like(image), np.zeros_like(alpha)
    for y, x in np.ndindex(alpha.shape):
        window = slice(max(y - radius, 0), y + radius + 1), slice(max(x - radius, 0), x + radius + 1)
        share, around = alpha[window].mean(), image[window].mean(axis=(0, 1))
        t = min(max((share - GONE) / (WHOLE - GONE), 0.0), 1.0)
        if t > 0:
            closed_alpha[y, x] = t * t * (3 - 2 * t)
            filled = image[y, x] + (1 - alpha[y, x]) * around / share
            closed_image[y, x] = closed_alpha[y, x] * filled
    return closed_image, closed_alpha
