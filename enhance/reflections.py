"""Reflections of the light: what is under them is not seen, so their surroundings stand for it."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np

from enhance.image import Float32Image

BRIGHT: Final = (np.float32(0.92), np.float32(0.98))
"""V from which on a block may be a reflection, and from which on it is one if it has no colour: at .9, pale
tissue of fetoscopy is taken for one."""
COLORLESS: Final = (np.float32(0.05), np.float32(0.15))
"""What green lacks beside red: up to the first it has no colour, from the second on it has; white lacks
nothing."""
RIM: Final = 1
"""Blocks around a reflection that it brightens."""
COARSE: Final = 4
"""Blocks along a side of those in which surroundings are averaged."""


def without_reflections(absorbed: Float32Image, value: Float32Image, radius: int) -> Float32Image:
    """What green lacks beside red, with reflections filled by the mean of the blocks around them.

    An opening takes the least that is near: beside a reflection, which lacks nothing, any tissue would look
    like a vessel, and get a dark rim.

    Args:
        absorbed: (h, w) means over blocks.
        value: V, of any size, the mean of 2 x 2 pixels or coarser.
        radius: blocks up to which the surroundings count, twice.
    """
    if not (value > BRIGHT[0]).any():
        return absorbed
    height, width = absorbed.shape
    bright = np.asarray(cv2.resize(value, (width, height)), np.float32)
    # Soft bounds: noise about them does not flicker.
    seen = 1 - _rise(bright, BRIGHT) * (1 - _rise(absorbed, COLORLESS))
    seen = np.asarray(cv2.erode(seen, np.ones((2 * RIM + 1, 2 * RIM + 1), np.uint8)), np.float32)
    size = -(-width // COARSE), -(-height // COARSE)
    reach = radius // COARSE * 4 + 1
    sums, shares = (
        np.asarray(cv2.blur(cv2.resize(plane, size, interpolation=cv2.INTER_AREA), (reach, reach)))
        for plane in (absorbed * seen, seen)
    )
    around = np.asarray(cv2.resize(sums / np.maximum(shares, np.float32(1e-3)), (width, height)))
    return np.asarray(absorbed + (1 - seen) * np.maximum(around - absorbed, 0), np.float32)


def _rise(values: Float32Image, bounds: tuple[np.float32, np.float32]) -> Float32Image:
    """0 up to the first bound, 1 from the second on."""
    low, high = bounds
    return np.asarray(np.clip((values - low) / (high - low), 0, 1), np.float32)
