"""The small images that tools are looked for in."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import BoolImage, ByteImage

SIDE: Final = 320
"""Pixels of the longer side: reflections and vessels are small there."""
SMALLEST: Final = 0.003
"""Of the image: what is smaller is no tool."""


def shrunk(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """(h, w, ...) of `SIDE` pixels at its longer side, of (H, W, ...)."""
    height, width = image.shape[:2]
    scale = SIDE / max(width, height)
    size = max(1, round(width * scale)), max(1, round(height * scale))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def shrunk_mask(mask: BoolImage) -> BoolImage:
    """(h, w) of (H, W), as `shrunk`: what most of a pixel is."""
    return shrunk(mask.astype(np.uint8) * 255) > 127


def disc(across: int) -> ByteImage:
    """To open, close, grow and shrink areas with."""
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (across, across)), dtype=np.uint8)
