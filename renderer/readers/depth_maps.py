"""Depth as files hold it: one picture in, (H, W) along +z out, with what cannot be meant set to 0."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from renderer.clip import ClipError
from renderer.readers.endonerf import OUTLIER
from renderer.readers.pictures import read_stored

DepthMap = NDArray[np.float32]


def read_map(path: Path) -> DepthMap:
    """The one channel of a picture, (H, W), with NaN, infinity and what is below 0 as 0.

    Raises:
        ClipError: the file is no picture, or one of several channels.
    """
    stored = read_stored(path)
    if stored.ndim != 2:
        raise ClipError(f"expected one channel, got {stored.shape[2]}: {path}")
    values = stored.astype(np.float32)
    return np.where(np.isfinite(values) & (values > 0), values, np.float32(0))


def plane_of(stored: NDArray[Any], path: Path) -> DepthMap:
    """(H, W) of what a file stores, without axes of length 1; NaN, infinity and what is below 0 as 0.

    Raises:
        ClipError: not one number a pixel.
    """
    plane = np.squeeze(stored)
    if plane.ndim != 2 or plane.dtype.kind not in "fiu":
        raise ClipError(f"expected one number a pixel, got {stored.dtype} {stored.shape}: {path}")
    values = plane.astype(np.float32)
    return np.where(np.isfinite(values) & (values > 0), values, np.float32(0))


def within(depth: DepthMap, nearest: float, farthest: float) -> DepthMap:
    """`depth` with what lies outside of [nearest, farthest] set to 0."""
    return np.where((depth >= nearest) & (depth <= farthest), depth, np.float32(0))


def plausible(depth: DepthMap) -> DepthMap:
    """`depth` without failed stereo matches: what is OUTLIER times farther or nearer than the median."""
    if not depth.any():
        return depth
    median = float(np.median(depth[depth > 0]))
    return within(depth, median / OUTLIER, median * OUTLIER)
