"""Brightness (Eqs 1 and 2): lift the dark range by as much as the histogram asks for."""

from __future__ import annotations

from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from enhance.image import Float32Image

Float = TypeVar("Float", bound=np.floating[Any])
Number = TypeVar("Number", bound=np.number[Any])

BLACK: Final = 24 / 255
"""V below which keep_black fades: the surround of real endoscopes holds noise of up to some 10 levels."""


def value(colors: NDArray[Number]) -> NDArray[Number]:
    """V of HSV, (H, W): the largest of R, G, B; a grey image is its own V."""
    if colors.ndim == 2:
        return colors
    return np.asarray(np.maximum(np.maximum(colors[..., 0], colors[..., 1]), colors[..., 2]))


def value_histogram(value: Float32Image) -> NDArray[np.int64]:
    """(256,) counts of V, rounded to 8 bits; of any shape."""
    levels = np.rint(value.ravel() * np.float32(255)).astype(np.uint8)
    return np.bincount(levels, minlength=256)


def level(cumulative: NDArray[np.int64], tenths: int = 1) -> int:
    """L of Eq 2: the smallest grey level where the cumulative histogram reaches 0.1, or so many tenths."""
    return int(cumulative.searchsorted(-(-tenths * int(cumulative[-1]) // 10)))


def z_from_level(level: float) -> float:
    """Eq 2, with L in grey levels, 0 to 255."""
    return min(max((level - 50) / 100, 0.0), 1.0)


def brighten(value: NDArray[Float], z: float) -> NDArray[Float]:
    """Vn of Eq 1, in [0, 1], in the precision of V; strictly increasing in V; exactly V at z = 1."""
    lift = value ** (0.75 * z + 0.25) + 0.4 * (1 - z) * (1 - value) + value ** (2 - z)
    return np.asarray(lift * 0.5, dtype=value.dtype)
