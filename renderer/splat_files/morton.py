"""An order in which neighbours in space are neighbours in the file (Morton)."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from renderer.splat_files.strays import bounds_without_strays

WHOLE: Final = 65535


def morton_order(means: NDArray[np.float32]) -> NDArray[np.int64]:
    """Rows of positions (N, 3) along the curve, by 16 bits of each coordinate within the bounds of most; what
    is beyond is at its end."""
    if not len(means):
        return np.zeros(0, np.int64)
    low, high = bounds_without_strays(means)
    within = (means.clip(low, high) - low) / np.maximum(high - low, np.finfo(np.float32).tiny)
    whole = (within * WHOLE).astype(np.int64)
    codes = np.zeros(len(means), np.int64)
    for bit in range(16):
        for axis in range(3):
            codes |= (whole[:, axis] >> bit & 1) << (3 * bit + axis)
    return np.argsort(codes, kind="stable")
