"""Which splats touch which tile, front to back: one depth sort, then tile lists by counting."""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.projection import CENTER_X, CENTER_Y, DEPTH, HALF_HEIGHT, HALF_WIDTH
from renderer.rasterize.prefetch import prefetch_row

TILE = 16
"""Side of a tile in pixels: one row of a tile is one vector of 16 float32."""
_RADIX_BITS = 11
_AHEAD = 16
"""Splats whose rectangles are on their way from memory."""


@njit(cache=True)
def depth_order(records: NDArray[np.float32], visible: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Indices of the visible splats by increasing depth, ties by index: a stable radix sort.

    The bits of positive float32 numbers, read as whole numbers, are in the order of the numbers.
    """
    count = 0
    order = np.empty(len(visible), np.int32)
    keys = np.empty(len(visible), np.uint32)
    depths = records[:, DEPTH].copy().view(np.uint32)
    for n in range(len(visible)):
        if visible[n]:
            order[count] = n
            keys[count] = depths[n]
            count += 1
    other_order, other_keys = np.empty(count, np.int32), np.empty(count, np.uint32)
    order, keys = order[:count], keys[:count]
    for shift in (0, _RADIX_BITS, 2 * _RADIX_BITS):
        starts = np.zeros((1 << _RADIX_BITS) + 1, np.int64)
        for i in range(count):
            starts[((keys[i] >> np.uint32(shift)) & np.uint32((1 << _RADIX_BITS) - 1)) + 1] += 1
        for bucket in range(1 << _RADIX_BITS):
            starts[bucket + 1] += starts[bucket]
        for i in range(count):
            bucket = (keys[i] >> np.uint32(shift)) & np.uint32((1 << _RADIX_BITS) - 1)
            place = starts[bucket]
            other_order[place], other_keys[place] = order[i], keys[i]
            starts[bucket] = place + 1
        order, other_order = other_order, order
        keys, other_keys = other_keys, keys
    return order


@njit(parallel=True, cache=True)
def find_rectangles(
    records: NDArray[np.float32],
    visible: NDArray[np.bool_],
    rows: int,
    columns: int,
    rectangles: NDArray[np.int16],  # (N, 4), out: first and last tile column, first and last tile row
) -> None:
    """The tiles that each splat reaches; the last column lies before the first where it reaches none."""
    for n in prange(len(visible)):
        rectangles[n, 0], rectangles[n, 1], rectangles[n, 2], rectangles[n, 3] = 0, -1, 0, -1
        if visible[n]:
            u, v = np.float64(records[n, CENTER_X]), np.float64(records[n, CENTER_Y])
            half_width, half_height = np.float64(records[n, HALF_WIDTH]), np.float64(records[n, HALF_HEIGHT])
            first_column = _tile_at(math.ceil(u - half_width - 0.5), columns)
            last_column = _tile_at(math.floor(u + half_width - 0.5), columns)
            first_row = _tile_at(math.ceil(v - half_height - 0.5), rows)
            last_row = _tile_at(math.floor(v + half_height - 0.5), rows)
            rectangles[n, 0], rectangles[n, 1] = max(first_column, 0), min(last_column, columns - 1)
            rectangles[n, 2], rectangles[n, 3] = max(first_row, 0), min(last_row, rows - 1)


@njit(forceinline=True)
def _tile_at(pixel: float, tiles: int) -> int:
    """Tile of a pixel coordinate of any size; -1 before the first tile, `tiles` behind the last."""
    return math.floor(min(max(pixel, -1.0), tiles * float(TILE)) * (1.0 / TILE))


@njit(cache=True)
def count_entries(
    rectangles: NDArray[np.int16],  # (N, 4)
    tile_wanted: NDArray[np.bool_],  # (tile rows, tile columns)
    slot_starts: NDArray[
        np.int64
    ],  # (N + 1,), out: entries of splat n are slot_starts[n] up to slot_starts[n + 1]
    tile_starts: NDArray[np.int64],  # (tiles + 1,), out
) -> int:
    """Count the (tile, splat) entries; tiles that are not wanted get none. Returns their number."""
    rows, columns = tile_wanted.shape
    tile_starts[:] = 0
    slot_starts[0] = 0
    for n in range(len(rectangles)):
        entries = 0
        for row in range(rectangles[n, 2], rectangles[n, 3] + 1):
            for column in range(rectangles[n, 0], rectangles[n, 1] + 1):
                if tile_wanted[row, column]:
                    tile_starts[row * columns + column + 1] += 1
                    entries += 1
        slot_starts[n + 1] = slot_starts[n] + entries
    for tile in range(rows * columns):
        tile_starts[tile + 1] += tile_starts[tile]
    return int(slot_starts[len(rectangles)])


@njit(parallel=True, cache=True)
def fill_entries(
    order: NDArray[np.int32],
    tile_wanted: NDArray[np.bool_],
    rectangles: NDArray[np.int16],
    slot_starts: NDArray[np.int64],
    tile_starts: NDArray[np.int64],
    bands: int,  # of tile rows, each filled by one thread
    entry_splats: NDArray[np.int32],  # out, grouped by tile, front to back in each
    slot_entries: NDArray[np.int32],  # out: the entries grouped by splat, row by row
) -> None:
    """The tile lists; they are the same whatever the number of bands."""
    rows, columns = tile_wanted.shape
    cursors = tile_starts[:-1].copy()
    for band in prange(bands):
        top, bottom = rows * band // bands, rows * (band + 1) // bands
        for i in range(len(order)):
            if i + _AHEAD < len(order):
                prefetch_row(rectangles, order[i + _AHEAD])
                prefetch_row(slot_starts, order[i + _AHEAD])
            n = order[i]
            first, last = rectangles[n, 2], rectangles[n, 3]
            if last < top or first >= bottom:
                continue
            slot = slot_starts[n]
            for row in range(first, min(last + 1, bottom)):
                for column in range(rectangles[n, 0], rectangles[n, 1] + 1):
                    if tile_wanted[row, column]:
                        if row >= top:
                            tile = row * columns + column
                            place = cursors[tile]
                            entry_splats[place], slot_entries[slot] = n, place
                            cursors[tile] = place + 1
                        slot += 1


def balanced_order(tile_starts: NDArray[np.int64], n_threads: int) -> NDArray[np.int32]:
    """Tiles ordered so that equal consecutive shares, one a thread, hold about equal work."""
    by_work = np.argsort(-np.diff(tile_starts), kind="stable").astype(np.int32)
    return np.concatenate([by_work[thread::n_threads] for thread in range(n_threads)])
