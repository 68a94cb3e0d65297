"""Depth as files hold it: a picture or array in, (H, W) along +z out, with what cannot be meant set to 0."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from renderer.clip import ClipError
from renderer.readers.image_files.file_kinds import is_array, is_picture
from renderer.readers.image_files.pictures import read_stored

OUTLIER: Final = 3.0
"""Depth beyond this many times a frame's median, or below its inverse, is a failed match."""

DepthMap = NDArray[np.float32]


def is_map(path: Path) -> bool:
    """Whether the name is one of a visible file that `read_map` reads."""
    return is_picture(path) or is_array(path)


def read_map(path: Path) -> DepthMap:
    """(H, W) of a picture or .npy file. Raises ClipError: it is none, or as `plane_of`."""
    return plane_of(read_stored(path), path)


def plane_of(stored: NDArray[Any], path: Path) -> DepthMap:
    """(H, W) of what a file stores, without axes of length 1; NaN, infinity and what is below 0 as 0.

    Raises:
        ClipError: not one number a pixel.
    """
    plane = stored if stored.ndim == 2 else np.squeeze(stored)
    if plane.ndim != 2 or plane.dtype.kind not in "bfiu":
        raise ClipError(f"expected one number a pixel, got {stored.dtype} {stored.shape}: {path}")
    values = plane.astype(np.float32)
    return np.where(np.isfinite(values) & (values > 0), values, np.float32(0))


def within(depth: DepthMap, nearest: float, farthest: float) -> DepthMap:
    """`depth` with what lies outside of [nearest, farthest] set to 0."""
    return np.where((depth >= nearest) & (depth <= farthest), depth, np.float32(0))


def plausible(depth: DepthMap) -> DepthMap:
    """`depth` without failed matches, see OUTLIER: a single pixel at 1574 mm outweighs a frame at 70."""
    measured = depth[depth > 0]
    if not measured.size:
        return depth
    median = float(np.median(measured))
    return within(depth, median / OUTLIER, median * OUTLIER)
