"""Coarse noise of colour goes: differences of R, G and B to luma are those of a wide surround; luma stays.

Rows are smoothed so as they are read, in both passes of the preset `vessel`.
"""

from __future__ import annotations

from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.image import Float32Image
from enhance.part import part
from enhance.pixel_block import CHUNK, LUMA, ONE, ZERO
from enhance.powers import rounded
from enhance.recolor import BLACK
from enhance.wide_vectors import wide_vectors

GRID: Final = 4
"""Pixels along a side of the blocks whose colours are smoothed."""
SIGMA: Final = 2.0
"""Blocks."""
TAPS: Final = 17
LEAST: Final = np.float32(1e-3)
NO_COLORS: Final[Float32Image] = np.empty((3, 0, 0), np.float32)


def colors_around(pixels: NDArray[Any], full: int) -> Float32Image:
    """(3, h, w) differences to luma of blocks of pixels as `Shown` has them, smoothed, in their unit; what
    is black has no part in those beside it."""
    below, beside = -pixels.shape[0] % GRID, -pixels.shape[1] % GRID
    whole = (
        cv2.copyMakeBorder(pixels, 0, below, 0, beside, cv2.BORDER_REPLICATE) if below or beside else pixels
    )
    size = whole.shape[1] // GRID, whole.shape[0] // GRID
    # Linear, it takes the four pixels in the middle of each block: a fifth of the time of their mean.
    blocks = cv2.resize(whole, size, interpolation=cv2.INTER_LINEAR)
    red, green, blue = cv2.split(blocks)
    lit = np.minimum(cv2.max(cv2.max(red, green), blue) * (ONE / (np.float32(full) * BLACK)), ONE)
    luma = LUMA[0] * red + LUMA[1] * green + LUMA[2] * blue
    weight = np.maximum(_smooth(lit), LEAST)
    to_red, to_blue = (_smooth((plane - luma) * lit) / weight for plane in (red, blue))
    to_green = (to_red * LUMA[0] + to_blue * LUMA[2]) * (-ONE / LUMA[1])
    return np.asarray(np.stack((to_red, to_green, to_blue)), np.float32)


def _smooth(plane: Float32Image) -> Float32Image:
    return np.asarray(cv2.GaussianBlur(plane, (TAPS, TAPS), SIGMA), np.float32)


@part()
def recolor_row(
    line: NDArray[Any],  # (3, n), in and out: R, G and B of a row
    first: int,  # of the columns that are changed
    end: int,  # after the last of them
    colors: NDArray[np.float32],  # (2, 3, n) rows of `colors_around` on either side
    weight: np.float32,  # of the second of them
    share: np.float32,  # of the differences to luma that become those
    full: np.float32,  # the image's value of 1.0
    work: NDArray[np.float32],  # (2, CHUNK)
) -> None:
    """V never rises. One colour after the other: a loop over all three asks for more checks of what overlaps
    than LLVM makes, and is no vector code."""
    luma, most = work[0], work[1]
    for x0 in range(first, end, CHUNK):
        last = min(x0 + CHUNK, end)
        _gather(line[0, x0:last], line[1, x0:last], line[2, x0:last], luma, most)
        for color in range(3):
            pixels, even, odd = line[color, x0:last], colors[0, color, x0:last], colors[1, color, x0:last]
            if full > ONE:  # Whole numbers; as a constant, it costs nothing.
                _blend(pixels, luma, most, even, odd, weight, share, True)
            else:
                _blend(pixels, luma, most, even, odd, weight, share, False)


@part(forceinline=True, fastmath={"contract"})
def _gather(
    reds: NDArray[Any],
    greens: NDArray[Any],
    blues: NDArray[Any],
    luma: NDArray[np.float32],  # out
    most: NDArray[np.float32],  # out: V
) -> None:
    wide_vectors()
    for i in range(len(reds)):
        red, green, blue = np.float32(reds[i]), np.float32(greens[i]), np.float32(blues[i])
        luma[i] = LUMA[0] * red + LUMA[1] * green + LUMA[2] * blue
    for i in range(len(reds)):
        red, green, blue = np.float32(reds[i]), np.float32(greens[i]), np.float32(blues[i])
        larger = red if red > green else green
        most[i] = larger if larger > blue else blue


@part(forceinline=True, fastmath={"contract"})
def _blend(
    pixels: NDArray[Any],  # of one colour, in and out
    luma: NDArray[np.float32],
    most: NDArray[np.float32],
    even: NDArray[np.float32],
    odd: NDArray[np.float32],
    weight: np.float32,
    share: np.float32,
    whole: bool,
) -> None:
    wide_vectors()
    for i in range(len(pixels)):
        color = np.float32(pixels[i])
        color += share * (luma[i] + (even[i] + weight * (odd[i] - even[i])) - color)
        color = color if color < most[i] else most[i]
        color = color if color > ZERO else ZERO
        if whole:
            pixels[i] = np.int32(rounded(color))  # type: ignore[call-arg]
        else:
            pixels[i] = color
