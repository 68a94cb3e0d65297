"""The hot loops: blending of the tile lists (paper Eq 16) and its gradient, 16 pixels a vector.

The shape of these loops is what makes them fast, so that LLVM turns each `for lane` loop into straight
vector code: a tile is 16 blocks of 4x4 pixels, a block is one vector, and only blocks that a splat's
rectangle reaches are visited; state lies on the stack, aligned, so that its planes cannot overlap; the trip
count is the constant 16; arithmetic is float32 only; choices are selects, not branches; nothing calls out of
the loop, as math.floor would. Within a block the exponent is its value at the corner, its slopes there, and
`bend`, the same for all blocks of a splat.
`contract` lets multiplications and additions fuse; the order of sums is fixed when compiled, so that results
repeat bit for bit whatever the number of threads.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.projection import (
    ACROSS,
    BLUE,
    CENTER_X,
    CENTER_Y,
    DEPTH,
    DOWN,
    GREEN,
    HALF_HEIGHT,
    HALF_WIDTH,
    LOG2_OPACITY,
    RED,
    SHEAR,
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
)
from renderer.rasterize.binning import TILE
from renderer.rasterize.exp2 import exp2
from renderer.rasterize.prefetch import prefetch_row
from renderer.stack_arrays import stack_array

# Planes of the blended picture: what light is left, colour without background, and sum of w z.
LEFT, PLANE_RED, PLANE_GREEN, PLANE_BLUE, PLANE_DEPTH = range(5)
PLANES = 5
# Planes of the adjoint, for a loss that is linear in the blending weights w of each pixel:
# dL/dw = color . (BY_RED, BY_GREEN, BY_BLUE) + z BY_DEPTH + BY_WEIGHT; TOTAL is the sum of w dL/dw.
BY_RED, BY_GREEN, BY_BLUE, BY_DEPTH, BY_WEIGHT, TOTAL = range(6)
ADJOINT_PLANES = 6
_STATE_PLANES = ADJOINT_PLANES + 2
"""Of the backward pass: the adjoint, then the light left, then the running sum."""

ZERO, ONE, TWO, HALF = np.float32(0.0), np.float32(1.0), np.float32(2.0), np.float32(0.5)
BLOCK = 4
"""Side of a block in pixels. Its 16 pixels are one vector; a splat costs nothing where it does not reach."""
BLOCKS_ACROSS = TILE // BLOCK
LAST = np.float32(TILE - 1)
BLOCKS, LANES = BLOCKS_ACROSS**2, BLOCK**2
ALPHA_CAP = np.float32(0.99)
LOG2_CUT = np.float32(math.log2(1.0 / 255.0))
LOWEST = np.float32(-9.0)
"""Exponents below the cut that exp2 still takes."""
STOP = np.float32(1e-4)
"""A pixel takes no more splats once less light than this is left."""
BATCH = 16
"""Splats between two looks at whether all pixels have stopped."""
AHEAD = 8
"""Splats whose records are on their way from memory."""


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _blocks(center: np.float32, half: np.float32) -> tuple[int, int]:
    """First and last block, of the tile's four, that center +- half reaches; in pixels of the tile."""
    first = max(ZERO, np.ceil(center - half))
    last = max(-ONE, min(LAST, np.floor(center + half)))
    return int(first) // BLOCK, int(last) // BLOCK


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _alpha(exponent: np.float32, light: np.float32) -> np.float32:
    """2**exponent, capped, and 0 below the cut or where a pixel has stopped."""
    alpha = exp2(max(exponent, LOWEST))
    alpha = alpha if alpha < ALPHA_CAP else ALPHA_CAP
    alpha = alpha if exponent >= LOG2_CUT else ZERO
    return alpha if light >= STOP else ZERO


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _set_lanes(across: NDArray[np.float32], down: NDArray[np.float32]) -> None:
    """Each lane's pixel within a block."""
    for lane in range(LANES):
        across[lane] = np.float32(lane % BLOCK)
        down[lane] = np.float32(lane // BLOCK)


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _set_bend(
    a: np.float32,
    shear: np.float32,
    d: np.float32,
    across: NDArray[np.float32],
    down: NDArray[np.float32],
    bend: NDArray[np.float32],
) -> None:
    """What a splat's exponent bends by at each lane, beside its slopes at the block's corner."""
    for lane in range(LANES):
        y = down[lane]
        u = across[lane] + shear * y
        bend[lane] = a * u * u + d * y * y


@njit(forceinline=True)
def _record(records: NDArray[np.float32], splats: NDArray[np.int32], i: int) -> NDArray[np.float32]:
    """That of the i-th splat; one further on is fetched."""
    if i + AHEAD < len(splats):
        prefetch_row(records, splats[i + AHEAD])
    record: NDArray[np.float32] = records[splats[i]]
    return record


@njit(fastmath={"contract"}, error_model="numpy")
def _blend_tile(
    records: NDArray[np.float32],
    splats: NDArray[np.int32],  # front to back
    left: int,
    top: int,
    planes: NDArray[np.float32],  # (PLANES, TILE, TILE), out
) -> int:
    """Blend one tile at (left, top); returns how many of its splats were taken."""
    state = stack_array(PLANES, BLOCKS, LANES)
    across = stack_array(LANES)
    down = stack_array(LANES)
    bend = stack_array(LANES)
    _set_lanes(across, down)
    for block in range(BLOCKS):
        for lane in range(LANES):
            state[LEFT, block, lane] = ONE
            for plane in range(1, PLANES):
                state[plane, block, lane] = ZERO
    end = len(splats)
    for begin in range(0, len(splats), BATCH):
        count = min(BATCH, len(splats) - begin)
        for i in range(begin, begin + count):
            record = _record(records, splats, i)
            a, shear, d, log2_opacity = record[ACROSS], record[SHEAR], record[DOWN], record[LOG2_OPACITY]
            red, green, blue, depth = record[RED], record[GREEN], record[BLUE], record[DEPTH]
            center_x = record[CENTER_X] - np.float32(left) - HALF
            center_y = record[CENTER_Y] - np.float32(top) - HALF
            first_column, last_column = _blocks(center_x, record[HALF_WIDTH])
            first_row, last_row = _blocks(center_y, record[HALF_HEIGHT])
            _set_bend(a, shear, d, across, down, bend)
            for row in range(first_row, last_row + 1):
                dy = np.float32(BLOCK * row) - center_y
                for column in range(first_column, last_column + 1):
                    dx = np.float32(BLOCK * column) - center_x
                    u = dx + shear * dy
                    level = log2_opacity + a * u * u + d * dy * dy
                    slope_x = TWO * a * u
                    slope_y = shear * slope_x + TWO * d * dy
                    block = BLOCKS_ACROSS * row + column
                    for lane in range(LANES):
                        exponent = level + bend[lane] + across[lane] * slope_x + down[lane] * slope_y
                        light = state[LEFT, block, lane]
                        alpha = _alpha(exponent, light)
                        weight = alpha * light
                        state[LEFT, block, lane] = light - weight
                        state[PLANE_RED, block, lane] += weight * red
                        state[PLANE_GREEN, block, lane] += weight * green
                        state[PLANE_BLUE, block, lane] += weight * blue
                        state[PLANE_DEPTH, block, lane] += weight * depth
        if stopped(state):
            end = begin + count
            break
    for plane in range(PLANES):
        for y in range(TILE):
            for column in range(BLOCKS_ACROSS):
                for x in range(BLOCK):
                    planes[plane, y, BLOCK * column + x] = state[
                        plane, BLOCKS_ACROSS * (y // BLOCK) + column, BLOCK * (y % BLOCK) + x
                    ]
    return end


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
        top, left = (tile // columns) * TILE, (tile % columns) * TILE
        start, end = tile_starts[tile], tile_starts[tile + 1]
        tile_ends[tile] = start + _blend_tile(
            records,
            entry_splats[start:end],
            left,
            top,
            planes[:, top : top + TILE, left : left + TILE],
        )


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def stopped(state: NDArray[np.float32]) -> bool:
    for block in range(BLOCKS):
        for lane in range(LANES):
            if state[LEFT, block, lane] >= STOP:
                return False
    return True


# Rows of the lane sums that the backward pass keeps for one entry; the moments are of the blocks' corners.
_Q, _QX, _QY, _QXX, _QXY, _QYY, _WR, _WG, _WB, _WD = range(10)
_LANE_SUMS = 10


@njit(fastmath={"contract"}, error_model="numpy")
def _blend_tile_backward(
    records: NDArray[np.float32],
    splats: NDArray[np.int32],  # front to back
    left: int,
    top: int,
    adjoint: NDArray[np.float32],  # (ADJOINT_PLANES, TILE, TILE)
    sums: NDArray[np.float32],  # (splats, SUM_SIZE), out
) -> None:
    """Gradient sums of one tile's splats."""
    state = stack_array(_STATE_PLANES, BLOCKS, LANES)
    lanes = stack_array(_LANE_SUMS, LANES)
    across = stack_array(LANES)
    down = stack_array(LANES)
    bend = stack_array(LANES)
    _set_lanes(across, down)
    for plane in range(ADJOINT_PLANES):
        for y in range(TILE):
            for column in range(BLOCKS_ACROSS):
                for x in range(BLOCK):
                    state[plane, BLOCKS_ACROSS * (y // BLOCK) + column, BLOCK * (y % BLOCK) + x] = adjoint[
                        plane, y, BLOCK * column + x
                    ]
    for block in range(BLOCKS):
        for lane in range(LANES):
            state[ADJOINT_PLANES, block, lane] = ONE
            state[ADJOINT_PLANES + 1, block, lane] = ZERO
    for begin in range(0, len(splats), BATCH):
        count = min(BATCH, len(splats) - begin)
        for i in range(begin, begin + count):
            record = _record(records, splats, i)
            a, shear, d, log2_opacity = record[ACROSS], record[SHEAR], record[DOWN], record[LOG2_OPACITY]
            red, green, blue, depth = record[RED], record[GREEN], record[BLUE], record[DEPTH]
            center_x = record[CENTER_X] - np.float32(left) - HALF
            center_y = record[CENTER_Y] - np.float32(top) - HALF
            first_column, last_column = _blocks(center_x, record[HALF_WIDTH])
            first_row, last_row = _blocks(center_y, record[HALF_HEIGHT])
            _set_bend(a, shear, d, across, down, bend)
            for total in range(_LANE_SUMS):
                for lane in range(LANES):
                    lanes[total, lane] = ZERO
            for row in range(first_row, last_row + 1):
                dy = np.float32(BLOCK * row) - center_y
                for column in range(first_column, last_column + 1):
                    dx = np.float32(BLOCK * column) - center_x
                    u = dx + shear * dy
                    level = log2_opacity + a * u * u + d * dy * dy
                    slope_x = TWO * a * u
                    slope_y = shear * slope_x + TWO * d * dy
                    dxx, dxy, dyy = dx * dx, dx * dy, dy * dy
                    block = BLOCKS_ACROSS * row + column
                    for lane in range(LANES):
                        exponent = level + bend[lane] + across[lane] * slope_x + down[lane] * slope_y
                        light = state[ADJOINT_PLANES, block, lane]
                        alpha = _alpha(exponent, light)
                        weight = alpha * light
                        by_weight = (
                            red * state[BY_RED, block, lane]
                            + green * state[BY_GREEN, block, lane]
                            + blue * state[BY_BLUE, block, lane]
                            + depth * state[BY_DEPTH, block, lane]
                            + state[BY_WEIGHT, block, lane]
                        )
                        running = state[ADJOINT_PLANES + 1, block, lane] + weight * by_weight
                        behind = state[TOTAL, block, lane] - running
                        q = weight * by_weight - behind * (alpha / (ONE - alpha))
                        q = q if alpha < ALPHA_CAP else ZERO
                        state[ADJOINT_PLANES, block, lane] = light - weight
                        state[ADJOINT_PLANES + 1, block, lane] = running
                        lanes[_Q, lane] += q
                        lanes[_QX, lane] += q * dx
                        lanes[_QY, lane] += q * dy
                        lanes[_QXX, lane] += q * dxx
                        lanes[_QXY, lane] += q * dxy
                        lanes[_QYY, lane] += q * dyy
                        lanes[_WR, lane] += weight * state[BY_RED, block, lane]
                        lanes[_WG, lane] += weight * state[BY_GREEN, block, lane]
                        lanes[_WB, lane] += weight * state[BY_BLUE, block, lane]
                        lanes[_WD, lane] += weight * state[BY_DEPTH, block, lane]
            _store(lanes, across, down, sums[i])


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def blend_backward(
    records: NDArray[np.float32],
    tile_starts: NDArray[np.int64],
    tile_ends: NDArray[np.int64],
    tile_order: NDArray[np.int32],
    entry_splats: NDArray[np.int32],
    columns: int,
    adjoint: NDArray[np.float32],  # (ADJOINT_PLANES, rows * TILE, columns * TILE)
    entry_sums: NDArray[np.float32],  # (entries, SUM_SIZE), out
) -> None:
    """Gradient sums of every entry, front to back.

    What lies behind a splat is the pixel's total less the running sum, so that no list of blended
    splats is kept for the pixels.
    """
    for position in prange(len(tile_order)):
        tile = tile_order[position]
        top, left = (tile // columns) * TILE, (tile % columns) * TILE
        start, end = tile_starts[tile], tile_ends[tile]
        entry_sums[end : tile_starts[tile + 1]] = ZERO
        _blend_tile_backward(
            records,
            entry_splats[start:end],
            left,
            top,
            adjoint[:, top : top + TILE, left : left + TILE],
            entry_sums[start:end],
        )


@njit(fastmath={"contract", "reassoc"})
def _store(
    lanes: NDArray[np.float32],
    across: NDArray[np.float32],
    down: NDArray[np.float32],
    slot: NDArray[np.float32],
) -> None:
    """Sum the lanes, with the moments within a block taken here once for the whole entry."""
    q = qx = qy = qxx = qxy = qyy = red = green = blue = depth = ZERO
    for lane in range(LANES):
        x, y = across[lane], down[lane]
        by, by_x, by_y = lanes[_Q, lane], lanes[_QX, lane], lanes[_QY, lane]
        q += by
        qx += by_x + by * x
        qy += by_y + by * y
        qxx += lanes[_QXX, lane] + x * (TWO * by_x + x * by)
        qxy += lanes[_QXY, lane] + x * by_y + y * (by_x + x * by)
        qyy += lanes[_QYY, lane] + y * (TWO * by_y + y * by)
        red += lanes[_WR, lane]
        green += lanes[_WG, lane]
        blue += lanes[_WB, lane]
        depth += lanes[_WD, lane]
    slot[SUM_Q], slot[SUM_QX], slot[SUM_QY] = q, qx, qy
    slot[SUM_QXX], slot[SUM_QXY], slot[SUM_QYY] = qxx, qxy, qyy
    slot[SUM_RED], slot[SUM_GREEN], slot[SUM_BLUE], slot[SUM_DEPTH] = red, green, blue, depth


@njit(parallel=True, cache=True)
def reduce_sums(
    entry_sums: NDArray[np.float32],
    slot_entries: NDArray[np.int32],
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
            entry = slot_entries[slot]
            for column in range(SUM_SIZE):
                sums[n, column] += entry_sums[entry, column]
