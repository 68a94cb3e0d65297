"""Rows of a grid brought up to the size of the image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from enhance.image import Float32Image
from enhance.part import part
from enhance.pixel_block import HALF, ONE, ZERO, copy_row
from enhance.prefetch import fetch_row
from enhance.wide_vectors import wide_vectors


@part()
def bring_up(
    models: NDArray[np.float32],  # (n, h, w), each pixel a block of the image
    y: int,
    grid: int,
    lines: NDArray[np.float32],  # (2, n, W), in and out: an even row and an odd one
    held: NDArray[np.int64],  # (2,), in and out: which rows these are
) -> np.float32:
    """See that the rows of the models around `y` are there; how much of the odd one there is at y.

    Linear, pixel centres aligned; the border repeats.
    """
    rows = models.shape[1]
    at = (np.float32(y) + HALF) / np.float32(grid) - HALF
    at = min(max(at, ZERO), np.float32(rows - 1))
    first = min(int(at), max(rows - 2, 0))
    for row in range(first, first + 2):
        if held[row % 2] != row:
            held[row % 2] = row
            for plane in range(len(models)):
                _widen(models[plane, min(row, rows - 1)], grid, lines[row % 2, plane])
                fetch_row(models[plane], row + 1)
    below = at - np.float32(first)
    return below if first % 2 == 0 else ONE - below


@part()
def _widen(row: NDArray[np.float32], grid: int, line: NDArray[np.float32]) -> None:
    """Bring a row up linearly, pixel centres aligned; the border repeats to the left and right."""
    if grid == 1:
        copy_row(row, line[: len(row)])
    elif grid == 2:
        _widen_by(row, 2, line)
    elif grid == 4:
        _widen_by(row, 4, line)
    else:
        _widen_by(row, grid, line)


@part(forceinline=True, fastmath={"contract"})
def _widen_by(row: NDArray[np.float32], grid: int, line: NDArray[np.float32]) -> None:
    """Where `grid` is a constant, this becomes vector code."""
    wide_vectors()
    last = len(row) - 1
    _spread(row[0], row[0], row[min(1, last)], grid, 0, line)
    for x in range(1, last):
        _spread(row[x - 1], row[x], row[x + 1], grid, x * grid, line)
    _spread(row[max(last - 1, 0)], row[last], row[last], grid, last * grid, line)


@part(forceinline=True, fastmath={"contract"})
def _spread(
    left: np.float32, middle: np.float32, right: np.float32, grid: int, at: int, line: NDArray[np.float32]
) -> None:
    for k in range(grid):
        offset = (np.float32(k) + HALF) / np.float32(grid) - HALF
        near = left if offset < ZERO else right
        line[at + k] = middle + abs(offset) * (near - middle)


def at_places(
    blocks: Float32Image, rows: NDArray[np.intp], columns: NDArray[np.intp], grid: int
) -> Float32Image:
    """(n, m) what `bring_up` gives of (h, w) blocks of `grid` pixels at these rows and columns."""
    above, below, down = _around(rows, blocks.shape[0], grid)
    left, right, along = _around(columns, blocks.shape[1], grid)
    down = down[:, None]

    def at_columns(x: NDArray[np.intp]) -> Float32Image:
        near, far = blocks[above[:, None], x], blocks[below[:, None], x]
        return near + down * (far - near)

    near, far = at_columns(left), at_columns(right)
    return near + along * (far - near)


def _around(
    places: NDArray[np.intp], size: int, grid: int
) -> tuple[NDArray[np.intp], NDArray[np.intp], Float32Image]:
    """(n,) the blocks before and after each place, and the share of the latter."""
    at = np.clip((places.astype(np.float32) + HALF) / np.float32(grid) - HALF, ZERO, np.float32(size - 1))
    first = np.minimum(at.astype(np.intp), max(size - 2, 0))
    return first, np.minimum(first + 1, size - 1), at - first.astype(np.float32)
