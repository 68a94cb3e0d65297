"""How much colour an image has beside its noise."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enhance.field_circle import median
from enhance.part import part

SAMPLES: Final = 1024
SIZE: Final = 6
"""Pixels of a sample's side: 3 x 3 means of 2 x 2 pixels, as cameras and codecs halve the colours."""
KERNEL: Final = ((1, -2, 1), (-2, 4, -2), (1, -2, 1))
"""Blind to planes (Immerkaer, Computer Vision and Image Understanding 64(2), 1996)."""
PER_DEVIATION: Final = 6 * 0.6745
"""Median size of the kernel's response to noise of deviation 1."""
ROUNDING: Final = 1.0
"""Grey levels: less noise than this is taken for it, as a screen shows no finer steps."""


def places(height: int, width: int) -> tuple[int, int, int]:
    """How far apart some SAMPLES evenly spread places of an image are, and how many rows and columns of them
    there are."""
    step = max(SIZE, int(math.sqrt(height * width / SAMPLES)))
    return step, max(0, (height - SIZE) // step + 1), max(0, (width - SIZE) // step + 1)


def chroma_snr(samples: NDArray[np.float64], full: int) -> float | None:
    """Mean of max - min of R, G and B over the noise of R - G or B - G, whichever is noisier, of the pixels
    that count; None: an image too small to tell.

    Noise is the median response to a kernel that is blind to planes, so that edges do not count.

    Args:
        samples: (3, n, m) of `sample_rows`; full: the image's value of 1.0.
    """
    to_levels = 255 / full
    chroma, response = _noise(samples, to_levels)
    if len(chroma) == 0:
        return None
    noise = to_levels * response / PER_DEVIATION
    return float(chroma.sum() / len(chroma)) / max(noise, ROUNDING)


@njit(cache=True, error_model="numpy")
def _noise(samples: NDArray[np.float64], to_levels: float) -> tuple[NDArray[np.float64], float]:
    """The chroma in grey levels of the samples that count, and the larger of their median responses."""
    found, count = np.empty((3, samples.shape[1] * samples.shape[2])), 0
    for row in range(samples.shape[1]):
        for column in range(samples.shape[2]):
            if samples[0, row, column] >= 0:
                found[0, count] = samples[0, row, column] * to_levels
                found[1, count], found[2, count] = samples[1, row, column], samples[2, row, column]
                count += 1
    response = max(median(found[1, :count]), median(found[2, :count])) if count > 0 else 0.0
    return found[0, :count], response


@part()
def sample_rows(
    pixels: NDArray[Any],  # (H, W, 3)
    keep: NDArray[np.uint8],  # as of `first_pass`
    spans: NDArray[np.int32],
    top: int,
    bottom: int,
    step: int,
    samples: NDArray[np.float64],  # (3, n, m), out: chroma, or -1; and responses of R - G and of B - G
) -> None:
    """Look at the `places` that begin in these rows of the image; -1 where one does not count."""
    for row in range((top + step - 1) // step, min((bottom + step - 1) // step, samples.shape[1])):
        for column in range(samples.shape[2]):
            y, x = row * step, column * step
            counts = len(keep) == 0 or keep[y + SIZE // 2, x + SIZE // 2] > 0
            for end in (y, y + SIZE - 1):
                if len(spans) > 0:
                    counts = counts and spans[end, 0] <= x and x + SIZE <= spans[end, 1]
            samples[0, row, column] = -1.0
            if counts:
                _sample(pixels, y, x, samples[:, row, column])


@part()
def _sample(pixels: NDArray[Any], y: int, x: int, sample: NDArray[np.float64]) -> None:
    """One place."""
    red, blue = 0.0, 0.0
    for v in range(SIZE):
        for u in range(SIZE):
            weight = 0.25 * KERNEL[v // 2][u // 2]
            green = np.float64(pixels[y + v, x + u, 1])
            red += weight * (np.float64(pixels[y + v, x + u, 0]) - green)
            blue += weight * (np.float64(pixels[y + v, x + u, 2]) - green)
    one = pixels[y + SIZE // 2, x + SIZE // 2]
    most, least = max(one[0], one[1], one[2]), min(one[0], one[1], one[2])
    sample[0] = np.float64(most) - np.float64(least)
    sample[1], sample[2] = abs(red), abs(blue)
