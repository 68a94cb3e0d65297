"""Averages over windows that are a share of the width of a picture."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Float32Image = NDArray[np.float32]

WIDEST = 640
"""Pixels across, beyond which the average is taken of a smaller picture: else one of 1280 takes a second, one
of 4K half a minute."""


def averaged(values: Float32Image, share: float) -> Float32Image:
    """(H, W) blurred by a Gaussian whose standard deviation is `share` of the width, at least a pixel.

    A picture wider than WIDEST is shrunk before and enlarged after, which a wide window hardly feels.
    """
    height, width = values.shape
    shrink = max(1.0, width / WIDEST)
    if shrink == 1:
        return np.asarray(cv2.GaussianBlur(values, (0, 0), max(share * width, 1.0)), np.float32)
    size = (round(width / shrink), max(1, round(height / shrink)))
    small = cv2.resize(values, size, interpolation=cv2.INTER_AREA)
    blurred = cv2.GaussianBlur(small, (0, 0), max(share * size[0], 1.0))
    return np.asarray(cv2.resize(blurred, (width, height), interpolation=cv2.INTER_LINEAR), np.float32)
