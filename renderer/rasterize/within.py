"""Blending of tiles that hold splats which the sides of an image or a field cut off, see crossings.py."""

from __future__ import annotations

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.camera import BoolArray, Camera
from renderer.in_view import InView
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
)
from renderer.rasterize.binning import TILE
from renderer.rasterize.crossings import crossings, margins
from renderer.rasterize.exp2 import exp2
from renderer.rasterize.tiles import (
    ALPHA_CAP,
    BATCH,
    HALF,
    LAST,
    LEFT,
    LOG2_CUT,
    LOWEST,
    ONE,
    PLANE_BLUE,
    PLANE_DEPTH,
    PLANE_GREEN,
    PLANE_RED,
    PLANES,
    STOP,
    ZERO,
    stopped,
)
from renderer.splats import Float32Array, Splats
from renderer.stack_arrays import stack_array

CUT = np.float32(1.0 / 255.0)


class Bounds:
    """Which of the splats that a camera sees are cut off by sides, and where."""

    def __init__(self, splats: Splats, camera: Camera, within: InView, visible: BoolArray) -> None:
        """Those that lie wholly beyond are no longer `visible`."""
        margin = margins(splats, within)
        visible &= margin > -1
        cut = np.flatnonzero(visible & (margin < 1))
        self._rows = np.full(len(splats), -1, np.int32)
        self._rows[cut] = np.arange(len(cut))
        given = splats.means, splats.quats, splats.scales
        means, quats, scales = (values[cut].astype(np.float64) for values in given)
        self._lines = crossings(means, quats, scales, camera, within).astype(np.float32)

    def tiles(self, tile_starts: NDArray[np.int64], entry_splats: NDArray[np.int32]) -> BoolArray:
        """Which tiles hold such splats."""
        cut = np.zeros(len(tile_starts) - 1, bool)
        _find_tiles(self._rows, tile_starts, entry_splats, cut)
        return cut

    def blend(
        self,
        records: NDArray[np.float32],
        tile_starts: NDArray[np.int64],
        tile_order: NDArray[np.int32],
        entry_splats: NDArray[np.int32],
        columns: int,
        planes: Float32Array,
    ) -> None:
        """The tiles in `tile_order`, as `blend` of tiles.py does it where no splat is cut."""
        _blend(records, self._rows, self._lines, tile_starts, tile_order, entry_splats, columns, planes)


@njit(parallel=True, cache=True, error_model="numpy")
def _find_tiles(
    rows: NDArray[np.int32],
    tile_starts: NDArray[np.int64],
    entry_splats: NDArray[np.int32],
    cut: BoolArray,  # (tiles,), out
) -> None:
    for tile in prange(len(cut)):
        for entry in range(tile_starts[tile], tile_starts[tile + 1]):
            if rows[entry_splats[entry]] >= 0:
                cut[tile] = True
                break


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def _blend(
    records: NDArray[np.float32],
    rows: NDArray[np.int32],  # (N,) of `lines`; -1: not cut
    lines: NDArray[np.float32],  # (cut, S, 3)
    tile_starts: NDArray[np.int64],
    tile_order: NDArray[np.int32],
    entry_splats: NDArray[np.int32],
    columns: int,
    planes: NDArray[np.float32],  # (PLANES, tile rows * TILE, columns * TILE), out
) -> None:
    for position in prange(len(tile_order)):
        tile = tile_order[position]
        splats = entry_splats[tile_starts[tile] : tile_starts[tile + 1]]
        top, left = (tile // columns) * TILE, (tile % columns) * TILE
        part = planes[:, top : top + TILE, left : left + TILE]
        _blend_tile(records, rows, lines, splats, left, top, part)


@njit(fastmath={"contract"}, error_model="numpy")
def _blend_tile(
    records: NDArray[np.float32],
    rows: NDArray[np.int32],
    lines: NDArray[np.float32],
    splats: NDArray[np.int32],  # front to back
    left: int,
    top: int,
    planes: NDArray[np.float32],  # (PLANES, TILE, TILE), out
) -> None:
    """As tiles.py, a row of pixels a vector, with the share of each pixel that lies inside."""
    whole, share = stack_array(TILE), stack_array(TILE)
    state = stack_array(PLANES, TILE, TILE)
    for y in range(TILE):
        whole[y] = ONE
        for x in range(TILE):
            state[LEFT, y, x] = ONE
            for plane in range(1, PLANES):
                state[plane, y, x] = ZERO
    for i in range(len(splats)):
        if i % BATCH == 0 and stopped(state):
            break
        record, row = records[splats[i]], rows[splats[i]]
        a, shear, d, log2_opacity = record[ACROSS], record[SHEAR], record[DOWN], record[LOG2_OPACITY]
        red, green, blue, depth = record[RED], record[GREEN], record[BLUE], record[DEPTH]
        center_x = record[CENTER_X] - np.float32(left) - HALF
        center_y = record[CENTER_Y] - np.float32(top) - HALF
        half_width, half_height = record[HALF_WIDTH], record[HALF_HEIGHT]
        first = int(max(ZERO, np.ceil(center_y - half_height)))
        last = int(max(-ONE, min(LAST, np.floor(center_y + half_height))))
        for y in range(first, last + 1):
            dy = np.float32(y) - center_y
            if row >= 0:
                _set_share(lines[row], -center_x, dy, share)
            inside = share if row >= 0 else whole
            bend = log2_opacity + d * dy * dy
            for x in range(TILE):
                dx = np.float32(x) - center_x
                u = dx + shear * dy
                exponent = bend + a * u * u
                light = state[LEFT, y, x]
                alpha = min(exp2(max(exponent, LOWEST)), ALPHA_CAP) * inside[x]
                alpha = alpha if exponent >= LOG2_CUT and alpha >= CUT else ZERO
                alpha = alpha if light >= STOP and abs(dx) <= half_width else ZERO
                weight = alpha * light
                state[LEFT, y, x] = light - weight
                state[PLANE_RED, y, x] += weight * red
                state[PLANE_GREEN, y, x] += weight * green
                state[PLANE_BLUE, y, x] += weight * blue
                state[PLANE_DEPTH, y, x] += weight * depth
    for plane in range(PLANES):
        for y in range(TILE):
            for x in range(TILE):
                planes[plane, y, x] = state[plane, y, x]


@njit(fastmath={"contract"}, error_model="numpy")
def _set_share(
    lines: NDArray[np.float32],  # (S, 3)
    dx: np.float32,
    dy: np.float32,
    share: NDArray[np.float32],  # (TILE,), of a row of pixels whose first one is at (dx, dy), out
) -> None:
    for x in range(TILE):
        share[x] = ONE
    for side in range(len(lines)):
        begin = lines[side, 0] + lines[side, 1] * dx + lines[side, 2] * dy + HALF
        if min(begin, begin + LAST * lines[side, 1]) < ONE:
            for x in range(TILE):
                share[x] = max(ZERO, min(share[x], begin + np.float32(x) * lines[side, 1]))
