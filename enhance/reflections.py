"""Reflections of the light: what is under them is not seen, so their surroundings stand for it."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.image import Float32Image
from enhance.part import part
from enhance.pixel_block import ONE, ZERO
from enhance.upscale import bring_up
from enhance.wide_vectors import wide_vectors

BRIGHT: Final = (np.float32(0.92), np.float32(0.98))
"""V from which on a block may be a reflection, and from which on it is one if it has no colour: at .9, pale
tissue of fetoscopy is taken for one."""
COLORLESS: Final = (np.float32(0.05), np.float32(0.15))
"""What green lacks beside red: up to the first it has no colour, from the second on it has; white lacks
nothing."""
RIM: Final = 1
"""Blocks around a reflection that it brightens; the kernels hold three rows."""
COARSE: Final = 4
"""Blocks along a side of those in which surroundings are averaged."""
STRIP: Final = 32
"""Rows of one task, a multiple of COARSE."""


def without_reflections(absorbed: Float32Image, value: Float32Image, radius: int) -> Float32Image:
    """What green lacks beside red, with reflections filled by the mean of the blocks around them.

    An opening takes the least that is near: beside a reflection, which lacks nothing, any tissue would look
    like a vessel, and get a dark rim.

    Args:
        absorbed: (h, w) means over blocks.
        value: V, of any size, the mean of 2 x 2 pixels or coarser.
        radius: blocks up to which the surroundings count, twice.
    """
    if value.max(initial=ZERO) <= BRIGHT[0]:
        return absorbed
    height, width = absorbed.shape
    if value.shape != absorbed.shape:
        value = np.asarray(cv2.resize(value, (width, height)), np.float32)
    seen = np.empty_like(absorbed)
    means = np.empty((2, -(-height // COARSE), -(-width // COARSE)), np.float32)
    _look(absorbed, value, seen, means)
    reach = radius // COARSE * 4 + 1
    sums, shares = (cv2.blur(plane, (reach, reach)) for plane in means)
    around = np.asarray(sums / np.maximum(shares, np.float32(1e-3)), np.float32)
    _fill(absorbed, around[None], seen)
    return seen


@njit(parallel=True, nogil=True, cache=True, error_model="numpy")
def _look(
    absorbed: NDArray[np.float32],  # (h, w)
    bright: NDArray[np.float32],  # (h, w) V
    seen: NDArray[np.float32],  # (h, w), out: 0 in a reflection and on its rim, 1 elsewhere
    means: NDArray[np.float32],  # (2, h / COARSE, w / COARSE) rounded up, out: of what is seen, and how much
) -> None:
    rows, columns = seen.shape
    for strip in prange((rows + STRIP - 1) // STRIP):
        top, bottom = strip * STRIP, min((strip + 1) * STRIP, rows)
        line = np.ones(columns + 2, np.float32)
        least = np.ones((3, columns), np.float32)
        piles = np.zeros((2, columns + COARSE), np.float32)
        for y in range(top - RIM, bottom + RIM):
            if 0 <= y < rows:
                _see(absorbed[y], bright[y], line[1:])
                _least_of_three(line, line[1:], line[2:], least[y % 3])
            else:
                least[y % 3] = ONE
            done = y - RIM
            if done >= top:
                _least_of_three(least[0], least[1], least[2], seen[done])
                _pile(absorbed[done], seen[done], piles)
                if done % COARSE == COARSE - 1 or done == rows - 1:
                    _average(piles, done % COARSE + 1, columns, means[:, done // COARSE])


@njit(parallel=True, nogil=True, cache=True, error_model="numpy")
def _fill(
    absorbed: NDArray[np.float32],  # (h, w)
    around: NDArray[np.float32],  # (1, h / COARSE, w / COARSE)
    seen: NDArray[np.float32],  # (h, w), replaced by what is filled: no other memory is touched
) -> None:
    rows, columns = seen.shape
    for strip in prange((rows + STRIP - 1) // STRIP):
        lines = np.empty((2, 1, columns + COARSE), np.float32)
        held = np.full(2, -1)
        for y in range(strip * STRIP, min((strip + 1) * STRIP, rows)):
            weight = bring_up(around, y, COARSE, lines, held)
            _blend(absorbed[y], lines[0, 0], lines[1, 0], weight, seen[y])


@part()
def _see(absorbed: NDArray[np.float32], bright: NDArray[np.float32], seen: NDArray[np.float32]) -> None:
    """Soft bounds: noise about them does not flicker."""
    wide_vectors()
    for i in range(len(absorbed)):
        seen[i] = ONE - _rise(bright[i], BRIGHT) * (ONE - _rise(absorbed[i], COLORLESS))


@part(forceinline=True)
def _rise(value: np.float32, bounds: tuple[np.float32, np.float32]) -> np.float32:
    """0 up to the first bound, 1 from the second on."""
    risen = (value - bounds[0]) * (ONE / (bounds[1] - bounds[0]))
    risen = risen if risen > ZERO else ZERO
    return risen if risen < ONE else ONE


@part()
def _least_of_three(
    a: NDArray[np.float32], b: NDArray[np.float32], c: NDArray[np.float32], out: NDArray[np.float32]
) -> None:
    wide_vectors()
    for i in range(len(out)):
        least = a[i] if a[i] < b[i] else b[i]
        out[i] = least if least < c[i] else c[i]


@part()
def _pile(absorbed: NDArray[np.float32], seen: NDArray[np.float32], piles: NDArray[np.float32]) -> None:
    wide_vectors()
    sums, shares = piles[0], piles[1]
    for i in range(len(absorbed)):
        sums[i] += absorbed[i] * seen[i]
        shares[i] += seen[i]


@part()
def _average(piles: NDArray[np.float32], height: int, columns: int, means: NDArray[np.float32]) -> None:
    """Sums of columns to means of blocks; then they begin anew."""
    wide_vectors()
    for plane in range(2):
        pile = piles[plane]
        for x in range(means.shape[1]):
            width = min(COARSE, columns - COARSE * x)
            first = np.uint64(COARSE * x)
            total = pile[first] + pile[first + np.uint64(1)] + pile[first + np.uint64(2)]
            means[plane, x] = (total + pile[first + np.uint64(3)]) / np.float32(height * width)
        pile[:] = ZERO


@part()
def _blend(
    absorbed: NDArray[np.float32],
    even: NDArray[np.float32],
    odd: NDArray[np.float32],
    weight: np.float32,
    seen: NDArray[np.float32],
) -> None:
    wide_vectors()
    for i in range(len(absorbed)):
        around = even[i] + weight * (odd[i] - even[i])
        lack = around - absorbed[i] if around > absorbed[i] else ZERO
        seen[i] = absorbed[i] + (ONE - seen[i]) * lack
