"""An order in which neighbours in space are neighbours in the file (Morton)."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

WHOLE: Final = 65535


def morton_order(means: NDArray[np.float32]) -> NDArray[np.int64]:
    """Rows of positions (N, 3) along the curve, by 16 bits of each coordinate."""
    low, size = means.min(axis=0, initial=np.inf), np.ptp(means, axis=0) if len(means) else np.ones(3)
    whole = ((means - low) / np.maximum(size, np.finfo(np.float32).tiny) * WHOLE).astype(np.int64)
    codes = np.zeros(len(means), np.int64)
    for bit in range(16):
        for axis in range(3):
            codes |= (whole[:, axis] >> bit & 1) << (3 * bit + axis)
    return np.argsort(codes, kind="stable")
