"""The hot loops: blending of the tile lists (paper Eq 16) and its gradient, 16 pixels a vector.

The shape of these loops is what makes them fast, so that LLVM turns each `for x` loop into straight
vector code: one local block of constant shape holds a tile's state, so that its planes cannot overlap;
the trip count is the constant 16; arithmetic is float32 only; choices are selects, not branches.
`contract` lets multiplications and additions fuse; sums are never reordered, so that results repeat
bit for bit whatever the number of threads.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.projection import (
    BLUE,
    CENTER_X,
    CENTER_Y,
    DEPTH,
    GREEN,
    HALF_HEIGHT,
    LOG2_OPACITY,
    RED,
    SUM_BLUE,
    SUM_DEPTH,
    SUM_GREEN,
    SUM_Q,
    SUM_QX,
    SUM_QXX,
    SUM_QXY,
    SUM_QY,
    SUM_QYY,
    SUM_RED,
    SUM_SIZE,
    A,
    B,
    C,
)
from renderer.rasterize.binning import TILE
from renderer.rasterize.exp2 import exp2

# Planes of the blended picture: what light is left, colour without background, and sum of w z.
LEFT, PLANE_RED, PLANE_GREEN, PLANE_BLUE, PLANE_DEPTH = range(5)
PLANES = 5
# Planes of the adjoint, for a loss that is linear in the blending weights w of each pixel:
# dL/dw = color . (BY_RED, BY_GREEN, BY_BLUE) + z BY_DEPTH + BY_WEIGHT; TOTAL is the sum of w dL/dw.
BY_RED, BY_GREEN, BY_BLUE, BY_DEPTH, BY_WEIGHT, TOTAL = range(6)
ADJOINT_PLANES = 6

ZERO, ONE, HALF = np.float32(0.0), np.float32(1.0), np.float32(0.5)
ALPHA_CAP = np.float32(0.99)
LOG2_CUT = np.float32(math.log2(1.0 / 255.0))
LOWEST = np.float32(-9.0)
"""Exponents below the cut that exp2 still takes."""
STOP = np.float32(1e-4)
"""A pixel takes no more splats once less light than this is left."""
_CHECK = 8
"""Entries between two looks at whether a whole tile has stopped."""


@njit(inline="always")
def _rows(record: NDArray[np.float32], top: int) -> tuple[np.float32, int, int]:
    """A splat's centre in rows of the tile that begins at pixel row `top`; first and last row reached."""
    center = record[CENTER_Y] - np.float32(top) - HALF
    first = max(0, math.ceil(center - record[HALF_HEIGHT]))
    last = min(TILE - 1, math.floor(center + record[HALF_HEIGHT]))
    return center, first, last


@njit(inline="always")
def _alpha(exponent: np.float32, light: np.float32) -> np.float32:
    """2**exponent, capped, and 0 below the cut or where a pixel has stopped."""
    alpha = exp2(max(exponent, LOWEST))
    alpha = alpha if alpha < ALPHA_CAP else ALPHA_CAP
    alpha = alpha if exponent >= LOG2_CUT else ZERO
    return alpha if light >= STOP else ZERO


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def blend(
    records: NDArray[np.float32],
    tile_starts: NDArray[np.int64],
    tile_order: NDArray[np.int32],
    entry_splats: NDArray[np.int32],
    columns: int,
    planes: NDArray[np.float32],  # (PLANES, rows * TILE, columns * TILE), out
    tile_ends: NDArray[np.int64],  # (tiles,), out: where blending stopped in the tile's list
) -> None:
    """Front-to-back blending of every tile."""
    for position in prange(len(tile_order)):
        tile = tile_order[position]
        state = np.empty((PLANES, TILE, TILE), np.float32)
        lane = np.empty(TILE, np.float32)
        top, left = (tile // columns) * TILE, (tile % columns) * TILE
        for x in range(TILE):
            lane[x] = np.float32(x) + HALF
        for y in range(TILE):
            for x in range(TILE):
                state[LEFT, y, x] = ONE
                for plane in range(1, PLANES):
                    state[plane, y, x] = ZERO
        end = tile_starts[tile + 1]
        for entry in range(tile_starts[tile], tile_starts[tile + 1]):
            record = records[entry_splats[entry]]
            a, b, c, log2_opacity = record[A], record[B], record[C], record[LOG2_OPACITY]
            red, green, blue, depth = record[RED], record[GREEN], record[BLUE], record[DEPTH]
            start = np.float32(left) - record[CENTER_X]
            center_row, first, last = _rows(record, top)
            for y in range(first, last + 1):
                dy = np.float32(y) - center_row
                row_slope, row_level = b * dy, log2_opacity + c * dy * dy
                for x in range(TILE):
                    dx = lane[x] + start
                    exponent = row_level + dx * (row_slope + a * dx)
                    light = state[LEFT, y, x]
                    alpha = _alpha(exponent, light)
                    weight = alpha * light
                    state[LEFT, y, x] = light - weight
                    state[PLANE_RED, y, x] += weight * red
                    state[PLANE_GREEN, y, x] += weight * green
                    state[PLANE_BLUE, y, x] += weight * blue
                    state[PLANE_DEPTH, y, x] += weight * depth
            if entry % _CHECK == 0 and _stopped(state):
                end = entry + 1
                break
        tile_ends[tile] = end
        for plane in range(PLANES):
            for y in range(TILE):
                for x in range(TILE):
                    planes[plane, top + y, left + x] = state[plane, y, x]


@njit(inline="always")
def _stopped(state: NDArray[np.float32]) -> bool:
    most = ZERO
    for y in range(TILE):
        for x in range(TILE):
            light = state[LEFT, y, x]
            most = light if light > most else most
    return bool(most < STOP)


# Rows of the lane sums that the backward pass keeps for one entry.
_Q, _QY, _QYY, _WR, _WG, _WB, _WD = range(7)


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def blend_backward(
    records: NDArray[np.float32],
    tile_starts: NDArray[np.int64],
    tile_ends: NDArray[np.int64],
    tile_order: NDArray[np.int32],
    entry_splats: NDArray[np.int32],
    entry_slots: NDArray[np.int32],
    columns: int,
    adjoint: NDArray[np.float32],  # (ADJOINT_PLANES, rows * TILE, columns * TILE)
    slots: NDArray[np.float32],  # (entries, SUM_SIZE), out
) -> None:
    """Gradient sums of every entry, front to back.

    What lies behind a splat is the pixel's total less the running sum, so that no list of blended
    splats is kept for the pixels.
    """
    for position in prange(len(tile_order)):
        tile = tile_order[position]
        # State planes 0 to 5 are the adjoint, then the light left, then the running sum.
        state = np.empty((ADJOINT_PLANES + 2, TILE, TILE), np.float32)
        lanes = np.empty((7, TILE), np.float32)
        lane = np.empty(TILE, np.float32)
        top, left = (tile // columns) * TILE, (tile % columns) * TILE
        for x in range(TILE):
            lane[x] = np.float32(x) + HALF
        for plane in range(ADJOINT_PLANES):
            for y in range(TILE):
                for x in range(TILE):
                    state[plane, y, x] = adjoint[plane, top + y, left + x]
        for y in range(TILE):
            for x in range(TILE):
                state[ADJOINT_PLANES, y, x] = ONE
                state[ADJOINT_PLANES + 1, y, x] = ZERO
        for entry in range(tile_ends[tile], tile_starts[tile + 1]):
            slots[entry_slots[entry]] = ZERO
        for entry in range(tile_starts[tile], tile_ends[tile]):
            record = records[entry_splats[entry]]
            a, b, c, log2_opacity = record[A], record[B], record[C], record[LOG2_OPACITY]
            red, green, blue, depth = record[RED], record[GREEN], record[BLUE], record[DEPTH]
            start = np.float32(left) - record[CENTER_X]
            center_row, first, last = _rows(record, top)
            for row in range(7):
                for x in range(TILE):
                    lanes[row, x] = ZERO
            for y in range(first, last + 1):
                dy = np.float32(y) - center_row
                row_slope, row_level = b * dy, log2_opacity + c * dy * dy
                for x in range(TILE):
                    dx = lane[x] + start
                    exponent = row_level + dx * (row_slope + a * dx)
                    light = state[ADJOINT_PLANES, y, x]
                    alpha = _alpha(exponent, light)
                    weight = alpha * light
                    by_weight = (
                        red * state[BY_RED, y, x]
                        + green * state[BY_GREEN, y, x]
                        + blue * state[BY_BLUE, y, x]
                        + depth * state[BY_DEPTH, y, x]
                        + state[BY_WEIGHT, y, x]
                    )
                    running = state[ADJOINT_PLANES + 1, y, x] + weight * by_weight
                    behind = state[TOTAL, y, x] - running
                    q = weight * by_weight - behind * (alpha / (ONE - alpha))
                    q = q if alpha < ALPHA_CAP else ZERO
                    state[ADJOINT_PLANES, y, x] = light - weight
                    state[ADJOINT_PLANES + 1, y, x] = running
                    lanes[_Q, x] += q
                    lanes[_QY, x] += q * dy
                    lanes[_QYY, x] += q * dy * dy
                    lanes[_WR, x] += weight * state[BY_RED, y, x]
                    lanes[_WG, x] += weight * state[BY_GREEN, y, x]
                    lanes[_WB, x] += weight * state[BY_BLUE, y, x]
                    lanes[_WD, x] += weight * state[BY_DEPTH, y, x]
            _store(lanes, lane, start, slots[entry_slots[entry]])


@njit(inline="always")
def _store(
    lanes: NDArray[np.float32], lane: NDArray[np.float32], start: np.float32, slot: NDArray[np.float32]
) -> None:
    """Sum the lanes, with the moments in x taken here once for the whole entry."""
    q = qx = qy = qxx = qxy = qyy = red = green = blue = depth = ZERO
    for x in range(TILE):
        dx = lane[x] + start
        q += lanes[_Q, x]
        qx += lanes[_Q, x] * dx
        qxx += lanes[_Q, x] * dx * dx
        qy += lanes[_QY, x]
        qxy += lanes[_QY, x] * dx
        qyy += lanes[_QYY, x]
        red += lanes[_WR, x]
        green += lanes[_WG, x]
        blue += lanes[_WB, x]
        depth += lanes[_WD, x]
    slot[SUM_Q], slot[SUM_QX], slot[SUM_QY] = q, qx, qy
    slot[SUM_QXX], slot[SUM_QXY], slot[SUM_QYY] = qxx, qxy, qyy
    slot[SUM_RED], slot[SUM_GREEN], slot[SUM_BLUE], slot[SUM_DEPTH] = red, green, blue, depth


@njit(parallel=True, cache=True)
def reduce_slots(
    slots: NDArray[np.float32],
    slot_starts: NDArray[np.int64],
    seen: NDArray[np.bool_],  # (N,), out
    sums: NDArray[np.float32],  # (N, SUM_SIZE), out
) -> None:
    """Add up each splat's entries in their order: no atomics, so that results repeat bit for bit."""
    for n in prange(len(seen)):
        seen[n] = slot_starts[n + 1] > slot_starts[n]
        for column in range(SUM_SIZE):
            sums[n, column] = ZERO
        for slot in range(slot_starts[n], slot_starts[n + 1]):
            for column in range(SUM_SIZE):
                sums[n, column] += slots[slot, column]
