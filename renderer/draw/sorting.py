"""The order in which splats are blended: nearest first, ties by index."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

DepthKeys = Literal["float32"] | int
"""How finely depth is compared: every float32 value, or levels of so many bits, at most 16, over the range
present."""


def depth_order(depths: NDArray[np.floating[Any]], keys: DepthKeys) -> NDArray[np.uint32]:
    """Indices (N,) that sort positive, finite depths (N,) stably, nearest first.

    Levels are spread evenly between the least and the greatest depth, so one far outlier coarsens them;
    "float32" is exact and takes about twice as long. Both are radix sorts, which numpy's stable argsort is
    for 16-bit keys only: the bits of a positive float32 order as two such digits.
    """
    if isinstance(keys, int):
        return np.argsort(_levels(depths, 2**keys - 1), kind="stable").astype(np.uint32)
    bits = depths.astype(np.float32).view(np.uint32)
    by_low = np.argsort(bits.astype(np.uint16), kind="stable")
    high = (bits >> 16).astype(np.uint16)
    return by_low[np.argsort(high[by_low], kind="stable")].astype(np.uint32)


def _levels(depths: NDArray[np.floating[Any]], most: int) -> NDArray[np.uint16]:
    if len(depths) == 0:
        return np.zeros(0, dtype=np.uint16)
    nearest, farthest = float(depths.min()), float(depths.max())
    levels_per_unit = most / (farthest - nearest) if farthest > nearest else 0.0
    levels: NDArray[np.uint16] = ((depths - nearest) * levels_per_unit).astype(np.uint16)
    return levels
