"""Gaussians turned from x right, y down, z forward to x right, y up, z backward, or back, by a half turn."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from renderer.raw_gaussians import RawGaussians

FLIPS: Final = np.array([-1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1, 1], np.float32)
"""Sign of each function of harmonics.py when y and z change sign."""
AXES: Final = np.array([1, -1, -1], np.float32)
QUATS: Final = np.array([1, 1, -1, -1], np.float32)
"""Of w, x, y, z; the axes of each Gaussian are turned, too, which it looks the same from both sides of."""


def y_up(raw: RawGaussians) -> RawGaussians:
    """In the other axes."""
    return replace(
        raw,
        means=raw.means * AXES,
        quats=raw.quats * QUATS,
        harmonics=FLIPS[: raw.harmonics.shape[1], None] * raw.harmonics,
    )
