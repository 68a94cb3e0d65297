"""What a pixel looks like on its own and in its surroundings, in numbers that tell tools from tissue."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import ByteImage

Features = NDArray[np.float32]

SCALES: Final = (0.8, 2.5, 7.0, 16.0, 32.0)
"""px of the small image: standard deviations of the surroundings."""
TEXTURES: Final = (1.5, 5.0)
"""px of the small image: within which brightness varies."""
COUNT: Final = 3 * len(SCALES) + len(TEXTURES)
_FLOOR = 4.0  # Grey levels that keep the ratios of dark pixels small.
_WIDE = 5.0  # px: wider surroundings are smoothed at a quarter of the size, which changes them little.
_QUIET = 0.02  # Of ln(brightness): less variation is noise.


def features(small: ByteImage) -> Features:
    """(h, w, COUNT) of an RGB image (h, w, 3) as `renderer.tools.shrinking.shrunk` gives it.

    At each scale ln(R / G) and ln(G / B), which the lamp's distance does not change, and the logarithm of
    brightness; then how much that varies nearby, as a logarithm.
    """
    levels = small.astype(np.float32) + _FLOOR
    found: list[NDArray[np.float32]] = []
    for scale in SCALES:
        red, green, blue = np.moveaxis(_smoothed(levels, scale), 2, 0)
        found += [np.log(red / green), np.log(green / blue), np.log((red + green + blue) / 3)]
    bright = np.log(levels.mean(axis=2))
    for scale in TEXTURES:
        mean, square = cv2.GaussianBlur(bright, (0, 0), scale), cv2.GaussianBlur(bright**2, (0, 0), scale)
        found.append(np.log(np.sqrt(np.maximum(square - mean**2, 0)) + np.float32(_QUIET)))
    return np.stack(found, axis=2).astype(np.float32)


def _smoothed(levels: NDArray[np.float32], scale: float) -> NDArray[np.float32]:
    if scale < _WIDE:
        return np.asarray(cv2.GaussianBlur(levels, (0, 0), scale), dtype=np.float32)
    height, width = levels.shape[:2]
    size = max(1, width // 4), max(1, height // 4)
    quarter = cv2.GaussianBlur(cv2.resize(levels, size, interpolation=cv2.INTER_AREA), (0, 0), scale / 4)
    return np.asarray(cv2.resize(quarter, (width, height), interpolation=cv2.INTER_LINEAR), dtype=np.float32)
