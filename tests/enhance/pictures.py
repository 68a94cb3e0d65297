"""Synthetic pictures and the strategy that draws awkward ones."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

ByteImage = NDArray[np.uint8]
KINDS = ("noise", "vessels", "flat", "black", "white", "checks")
DTYPES = (np.uint8, np.uint16, np.float16, np.float32, np.float64)


def vessels(rows: int = 120, columns: int = 150, seed: int = 7) -> ByteImage:
    """(rows, columns, 3): unevenly lit pink tissue, dark red curved vessels, a highlight, a black corner."""
    y, x = np.mgrid[0:rows, 0:columns].astype(np.float64)
    light = 0.35 + 0.6 * np.exp(-((x - 0.6 * columns) ** 2 + (y - 0.4 * rows) ** 2) / (0.5 * rows) ** 2)
    color = np.stack([light, 0.62 * light, 0.55 * light], axis=2)
    for at, width in ((0.3, 1.2), (0.55, 2.5), (0.8, 4.0)):
        line = at * columns + 9 * np.sin(y / 17 + 6 * at)
        color *= 1 - np.exp(-(((x - line) / width) ** 2))[..., None] * np.array([0.25, 0.6, 0.5])
    color += 0.8 * np.exp(-((x - 0.6 * columns) ** 2 + (y - 0.4 * rows) ** 2) / 30)[..., None]
    color += np.random.default_rng(seed).normal(0, 0.01, color.shape)
    color[(x + y) < 0.2 * rows] = 0
    return np.rint(255 * np.clip(color, 0, 1)).astype(np.uint8)


def picture(kind: str, shape: tuple[int, ...], seed: int) -> NDArray[np.float64]:
    """Values in [0, 1] of the given kind and shape."""
    rng = np.random.default_rng(seed)
    if kind == "noise":
        return rng.random(shape)
    if kind == "vessels":
        whole = vessels(shape[0], shape[1], seed) / 255
        return whole[..., 0] if len(shape) == 2 else whole
    if kind == "flat":
        return np.broadcast_to(rng.random(shape[2:]), shape).copy()
    if kind == "checks":
        return rng.integers(0, 2, shape).astype(np.float64)
    return np.full(shape, 1.0 if kind == "white" else 0.0)


def as_type(values: NDArray[np.float64], dtype: Any) -> NDArray[Any]:
    kind = np.dtype(dtype)
    return np.rint(values * np.iinfo(kind).max).astype(kind) if kind.kind == "u" else values.astype(kind)


@st.composite
def images(draw: st.DrawFn, channels: tuple[int, ...] = (0, 3, 4)) -> NDArray[Any]:
    """1x1 to 65x97, every accepted type, grey (0 channels), RGB and RGBA."""
    size = draw(st.integers(1, 65)), draw(st.integers(1, 97))
    count = draw(st.sampled_from(channels))
    seed = draw(st.integers(0, 99))
    values = picture(draw(st.sampled_from(KINDS)), (*size, 3) if count else size, seed)
    if count == 4:
        alpha = np.random.default_rng(seed).integers(0, 3, size) / 2
        alpha[0, 0] = 1
        values = np.dstack((values, alpha))
    return as_type(values, draw(st.sampled_from(DTYPES)))
