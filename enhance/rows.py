"""Rows of an image that come in from above and are smoothed on the way.

Each row is read once, with what lies beside it; the border reflects, without the pixel at the border itself.
Weights are (1 2 1) / 4, nearly a Gaussian of 0.7 pixels: sums of 8-bit pixels stay whole numbers below 2^16,
and twice as many as of floats are added at once.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from enhance.calm_blotches import GRID, recolor_row
from enhance.interleave import deinterleave
from enhance.part import part
from enhance.pixel_block import CHUNK, ZERO
from enhance.upscale import bring_up
from enhance.wide_vectors import wide_vectors

REACH: Final = 1
"""Pixels on either side that count."""
ROWS: Final = 4
"""That are held, row y at place y % ROWS; a power of two that is at least 2 REACH + 1."""
SOFT = np.float32(1 / 16)
"""One over the sum of the weights."""


def sums_of(image: NDArray[Any]) -> NDArray[Any]:
    """Empty, of the type that weighted sums of an image's pixels have."""
    return np.empty(0, np.uint16 if image.dtype == np.uint8 else np.float32)


@part(forceinline=True)
def held_width(columns: int) -> int:
    """Of the rows that are held: whole chunks."""
    return (columns + CHUNK - 1) // CHUNK * CHUNK


@part(forceinline=True)
def reflected(at: int, size: int) -> int:
    """The place in [0, size) that stands for one outside."""
    while size > 1 and not 0 <= at < size:
        at = -at if at < 0 else 2 * (size - 1) - at
    return at if size > 1 else 0


@part()
def read_row(
    image: NDArray[Any],  # (H, W, 3)
    y: int,  # may lie outside
    spans: NDArray[np.int32],  # (H, 2) of `FieldOfView.spans`, or empty: all; outside, coarse noise stays
    full: np.float32,  # the image's value of 1.0
    around: NDArray[np.float32],  # (3, h, w) of `calm_blotches.colors_around`, or empty
    smoothing: np.float32,  # share of coarse noise of colour that goes
    colors: NDArray[np.float32],  # (2, 3, `held_width`), in and out: rows of `around` brought up
    held: NDArray[np.int64],  # (2,), in and out: which rows these are
    work: NDArray[np.float32],  # (2, CHUNK)
    lines: NDArray[Any],  # (ROWS, 3, `held_width`), in and out: of the rows' colours apart
    across: NDArray[Any],  # (ROWS, 3, `held_width`), in and out
) -> None:
    """Sums of three neighbours in row y, the middle one twice."""
    columns = image.shape[1]
    line, at = lines[y % ROWS], reflected(y, image.shape[0])
    deinterleave(image[at], line)
    if smoothing > ZERO:
        first, end = (spans[at, 0], spans[at, 1]) if len(spans) > 0 else (0, columns)
        weight = bring_up(around, at, GRID, colors, held)
        recolor_row(line, first, end, colors, weight, smoothing, full, work)
    for color in range(3):
        pixels, sums = line[color], across[y % ROWS, color]
        _add_across(pixels, sums[1:], columns - 2)
        for x in (0, columns - 1):
            beside = pixels[reflected(x - 1, columns)] + pixels[reflected(x + 1, columns)]
            sums[x] = beside + pixels[x] + pixels[x]


@part()
def _add_across(left: NDArray[Any], sums: NDArray[Any], count: int) -> None:
    wide_vectors()
    middle, right = left[1:], left[2:]
    for i in range(count):
        sums[i] = left[i] + right[i] + (middle[i] + middle[i])


@part()
def add_down(across: NDArray[Any], y: int, color: int, x0: int, sums: NDArray[Any]) -> None:
    """Weighted (1 2 1) of the rows around y: (CHUNK,) sums of the pixels from column x0 on."""
    wide_vectors()
    row, up, down = (
        across[y % ROWS, color, x0:],
        across[(y - 1) % ROWS, color, x0:],
        across[(y + 1) % ROWS, color, x0:],
    )
    for i in range(CHUNK):
        sums[i] = up[i] + down[i] + (row[i] + row[i])
