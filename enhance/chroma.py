"""How much colour an image has beside its noise."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

SAMPLES: Final = 1024
SIZE: Final = 6
"""Pixels of a sample's side: 3 x 3 means of 2 x 2 pixels, as cameras and codecs halve the colours."""
KERNEL: Final = ((1, -2, 1), (-2, 4, -2), (1, -2, 1))
"""Blind to planes (Immerkaer, Computer Vision and Image Understanding 64(2), 1996)."""
PER_DEVIATION: Final = 6 * 0.6745
"""Median size of the kernel's response to noise of deviation 1."""
ROUNDING: Final = 1.0
"""Grey levels: less noise than this is taken for it, as a screen shows no finer steps."""


def chroma_snr(
    pixels: NDArray[Any], keep: NDArray[np.uint8], spans: NDArray[np.int32], full: int
) -> float | None:
    """Mean of max - min of R, G and B over the noise of R - G or B - G, whichever is noisier, of the pixels
    that count; None: an image too small to tell.

    Some SAMPLES evenly spread places are looked at. Noise is the median response to a kernel that is blind to
    planes, so that edges do not count.

    Args:
        pixels: (H, W, 3); keep, spans: as of `first_pass`; full: the image's value of 1.0.
    """
    height, width = pixels.shape[:2]
    step = max(SIZE, int(math.sqrt(height * width / SAMPLES)))
    rows, columns = max(0, (height - SIZE) // step + 1), max(0, (width - SIZE) // step + 1)
    found = np.empty((3, rows * columns), np.float64)
    count = _sample(pixels, keep, spans, step, columns, found)
    if count == 0:
        return None
    to_levels = 255 / full
    # As np.median, in a fraction of its time.
    middle = [(count - 1) // 2, count // 2]
    medians = np.partition(found[1:, :count], middle, axis=1)[:, middle].mean(axis=1)
    noise = to_levels * float(medians.max()) / PER_DEVIATION
    return float((found[0, :count] * to_levels).mean()) / max(noise, ROUNDING)


@njit(cache=True, error_model="numpy")
def _sample(
    pixels: NDArray[Any],
    keep: NDArray[np.uint8],
    spans: NDArray[np.int32],
    step: int,
    columns: int,
    found: NDArray[np.float64],  # (3, most), out: chroma, and responses of R - G and of B - G
) -> int:
    """Look at places `step` apart, so many in a row; the number of those that count."""
    count = 0
    for place in range(found.shape[1]):
        y, x = place // columns * step, place % columns * step
        counts = len(keep) == 0 or keep[y + SIZE // 2, x + SIZE // 2] > 0
        for end in (y, y + SIZE - 1):
            if len(spans) > 0:
                counts = counts and spans[end, 0] <= x and x + SIZE <= spans[end, 1]
        if counts:
            red, blue = 0.0, 0.0
            for v in range(SIZE):
                for u in range(SIZE):
                    weight = 0.25 * KERNEL[v // 2][u // 2]
                    green = np.float64(pixels[y + v, x + u, 1])
                    red += weight * (np.float64(pixels[y + v, x + u, 0]) - green)
                    blue += weight * (np.float64(pixels[y + v, x + u, 2]) - green)
            one = pixels[y + SIZE // 2, x + SIZE // 2]
            most, least = max(one[0], one[1], one[2]), min(one[0], one[1], one[2])
            found[0, count] = np.float64(most) - np.float64(least)
            found[1, count], found[2, count] = abs(red), abs(blue)
            count += 1
    return count
