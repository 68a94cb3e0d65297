"""A splat as the shaders read it: four texels of four floats."""

from __future__ import annotations

import numpy as np

from renderer.splats import Float32Array, Splats

TEXELS = 4
"""mean opacity | quat wxyz | scales - | color -"""
MEAN, OPACITY, QUAT, SCALES, COLOR = slice(0, 3), 3, slice(4, 8), slice(8, 11), slice(12, 15)
SLOT = 15
"""Column for what belongs to no splat by itself: where its offsets over time are."""
PLACE, TURN, SIZE, PAINT = range(TEXELS)


def packed(splats: Splats) -> Float32Array:
    """(N, 16), SLOT left 0."""
    records = np.zeros((len(splats), 4 * TEXELS), np.float32)
    records[:, MEAN] = splats.means
    records[:, OPACITY] = splats.opacities
    records[:, QUAT] = splats.quats
    records[:, SCALES] = splats.scales
    records[:, COLOR] = splats.colors
    return records


def unpacked(records: Float32Array, harmonics: Float32Array) -> Splats:
    """Inverse of `packed`."""
    return Splats(
        means=records[:, MEAN],
        quats=records[:, QUAT],
        scales=records[:, SCALES],
        opacities=records[:, OPACITY],
        colors=records[:, COLOR],
        harmonics=harmonics,
    )
