"""Noise of colour goes, that of brightness stays: differences of R, G and B to luma are smoothed.

V never rises by it. Both passes of the preset `vessel` see the image so.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from enhance.part import part
from enhance.pixel_block import BLUE, CHUNK, GREEN, LEAST_COLOR, LUMA, RED, VALUE, ZERO
from enhance.rows import ROWS, SOFT, add_down
from enhance.wide_vectors import wide_vectors


@part(forceinline=True)
def calm(
    lines: NDArray[Any],  # of `read_row`, with the rows around y
    across: NDArray[Any],  # of `read_row`
    y: int,
    x0: int,
    unit: np.float32,  # one over the image's value of 1.0
    narrow: NDArray[Any],  # (3, CHUNK), out: sums about each pixel
    chunk: NDArray[np.float32],  # out: RED, GREEN, BLUE, VALUE and LEAST_COLOR
) -> None:
    """CHUNK pixels of row y from column x0 on."""
    for color in range(3):
        add_down(across, y, color, x0, narrow[color])
    row = y % ROWS
    _calm(lines[row, 0, x0:], lines[row, 1, x0:], lines[row, 2, x0:], narrow, unit, chunk)


@part(forceinline=True, fastmath={"contract"})
def _calm(
    reds: NDArray[Any],
    greens: NDArray[Any],
    blues: NDArray[Any],
    narrow: NDArray[Any],
    unit: np.float32,
    chunk: NDArray[np.float32],
) -> None:
    wide_vectors()
    scale = unit * SOFT
    for i in range(CHUNK):
        soft_red, soft_green = np.float32(narrow[0, i]) * scale, np.float32(narrow[1, i]) * scale
        soft_blue = np.float32(narrow[2, i]) * scale
        red, green = np.float32(reds[i]) * unit, np.float32(greens[i]) * unit
        blue = np.float32(blues[i]) * unit
        fine = LUMA[0] * (red - soft_red) + LUMA[1] * (green - soft_green) + LUMA[2] * (blue - soft_blue)
        most = red if red > green else green
        most = most if most > blue else blue
        red, green, blue = soft_red + fine, soft_green + fine, soft_blue + fine
        red, green = red if red < most else most, green if green < most else most
        blue = blue if blue < most else most
        red, green = red if red > ZERO else ZERO, green if green > ZERO else ZERO
        blue = blue if blue > ZERO else ZERO
        value = red if red > green else green
        least = red if red < green else green
        chunk[RED, i], chunk[GREEN, i], chunk[BLUE, i] = red, green, blue
        chunk[VALUE, i] = value if value > blue else blue
        chunk[LEAST_COLOR, i] = least if least < blue else blue
