"""Eyes whose rows lie a constant number of pixels apart, as of a rig that was mounted or cropped so."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import ByteImage

SMALLEST: Final = 0.5
"""px: rows that are closer are left as they are, as matching takes them."""
PAIRS: Final = 5
"""Pairs that are looked at, spread over the clip: one alone may have too few features to tell."""


def places(count: int) -> tuple[int, ...]:
    """Of the pairs that are looked at, among `count`."""
    return tuple(dict.fromkeys(np.linspace(0, count - 1, PAIRS).astype(int).tolist()))


def row_offset(shifts: Sequence[NDArray[np.float64]]) -> tuple[float, float]:
    """From shifts (M, 2) of several pairs, left minus right: by how much right images are to be moved down,
    and the median distance of rows in px that is left then, of the first pair or of all, the larger one."""
    every = np.concatenate(shifts)[:, 1]
    offset = float(np.median(every))
    if abs(offset) < SMALLEST:
        offset = 0.0
    return offset, max(float(np.median(np.abs(down - offset))) for down in (shifts[0][:, 1], every))


def moved_down(image: ByteImage, rows: float) -> ByteImage:
    """The image (H, W, 3) moved by so many rows, up where negative; what comes in repeats the edge."""
    move = np.array([[1, 0, 0], [0, 1, rows]], np.float32)
    size = (image.shape[1], image.shape[0])
    moved = cv2.warpAffine(image, move, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(moved, np.uint8)


def unseen(rows: float) -> slice:
    """The rows of the left image that an image moved by so many does not show."""
    count = math.ceil(abs(rows))
    return slice(0, count) if rows >= 0 else slice(-count, None)
