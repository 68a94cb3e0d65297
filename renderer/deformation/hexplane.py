"""HexPlane (Cao & Johnson 2023): six planes of features over space and time, multiplied at each point.

A level has three planes in space (xy, xz, yz) and three in time (xt, yt, zt). At one time the latter
are lines, mixed from the two rows around it, so that the kernels meet three planes and three lines.
Channels lie in blocks of 16, one vector; a task owns one block of one level, with its gradients, so that
results do not depend on the number of threads.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.splats import Float32Array

LANES = 16
"""Channels of a block."""
ONE, ZERO = np.float32(1.0), np.float32(0.0)


@dataclass(frozen=True, eq=False)
class Layout:
    """Where the planes and lines of each of L levels lie among the cells."""

    resolutions: NDArray[np.int64]
    """(L, 3) cells along x, y, z, at least 2."""
    planes: NDArray[np.int64]
    """(L, 3) first cell of xy, xz and yz, rows of which run along the first axis named."""
    lines: NDArray[np.int64]
    """(L, 3) first cell of the lines along x, y and z."""
    n_plane_cells: int
    n_line_cells: int

    @classmethod
    def of(cls, resolutions: NDArray[np.int32]) -> Self:
        counts = resolutions.astype(np.int64)
        x, y, z = counts.T
        planes, n_plane_cells = _starts(np.stack([x * y, x * z, y * z], axis=1))
        lines, n_line_cells = _starts(np.stack([x, y, z], axis=1))
        return cls(counts, planes, lines, n_plane_cells, n_line_cells)


def _starts(counts: NDArray[np.int64]) -> tuple[NDArray[np.int64], int]:
    ends = np.cumsum(counts).reshape(counts.shape)
    return ends - counts, int(ends[-1, -1])


def within_box(means: Float32Array, box: Float32Array) -> Float32Array:
    """Means (N, 3) as shares of the box (lowest and highest corner, (2, 3)), clamped to [0, 1]."""
    extent = box[1] - box[0]
    shares = (means - box[0]) / np.where(extent > 0, extent, ONE)
    return np.ascontiguousarray(np.clip(shares, ZERO, ONE), np.float32)


def time_taps(time: float, rows: int) -> tuple[int, np.float32]:
    """The row before `time` in [0, 1] and the share of the next one; both ends of time lie on rows."""
    position = min(max(time, 0.0), 1.0) * (rows - 1)
    row = min(int(position), rows - 2)
    return row, np.float32(position - row)


def lines_at(time_cells: Float32Array, time: float) -> Float32Array:
    """The lines (B, line cells, LANES) of time planes (T, B, line cells, LANES)."""
    row, share = time_taps(time, len(time_cells))
    lines: Float32Array = (ONE - share) * time_cells[row] + share * time_cells[row + 1]
    return lines


class _Place(NamedTuple):
    """Where a point lies in a level: its first cell on planes and lines, and the linear weights there."""

    xy: int
    xz: int
    yz: int
    x: int
    y: int
    z: int
    across: int
    """Cells from a row to the next on xy and xz."""
    down: int
    """On yz."""
    x0: np.float32
    x1: np.float32
    y0: np.float32
    y1: np.float32
    z0: np.float32
    z1: np.float32


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _corner(share: np.float32, count: int) -> tuple[int, np.float32, np.float32]:
    """Cell before a point of [0, 1] between `count` cells, and the weights of it and the next."""
    position = share * np.float32(count - 1)
    first = min(int(position), count - 2)
    after = position - np.float32(first)
    return first, ONE - after, after


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _place(
    point: Float32Array, counts: NDArray[np.int64], planes: NDArray[np.int64], lines: NDArray[np.int64]
) -> _Place:
    across, down, deep = counts[0], counts[1], counts[2]
    i, x0, x1 = _corner(point[0], across)
    j, y0, y1 = _corner(point[1], down)
    k, z0, z1 = _corner(point[2], deep)
    return _Place(
        planes[0] + j * across + i, planes[1] + k * across + i, planes[2] + k * down + j,
        lines[0] + i, lines[1] + j, lines[2] + k,
        across, down, x0, x1, y0, y1, z0, z1,
    )  # fmt: skip


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _values(cells: Float32Array, lines: Float32Array, at: _Place, c: int) -> tuple[np.float32, ...]:
    """Channel c of xy, xz, yz, xt, yt and zt at a point."""
    a, b, d = at.xy, at.xz, at.yz
    next_a, next_b, next_d = a + at.across, b + at.across, d + at.down
    xy = at.y0 * (at.x0 * cells[a, c] + at.x1 * cells[a + 1, c])
    xy += at.y1 * (at.x0 * cells[next_a, c] + at.x1 * cells[next_a + 1, c])
    xz = at.z0 * (at.x0 * cells[b, c] + at.x1 * cells[b + 1, c])
    xz += at.z1 * (at.x0 * cells[next_b, c] + at.x1 * cells[next_b + 1, c])
    yz = at.z0 * (at.y0 * cells[d, c] + at.y1 * cells[d + 1, c])
    yz += at.z1 * (at.y0 * cells[next_d, c] + at.y1 * cells[next_d + 1, c])
    xt = at.x0 * lines[at.x, c] + at.x1 * lines[at.x + 1, c]
    yt = at.y0 * lines[at.y, c] + at.y1 * lines[at.y + 1, c]
    zt = at.z0 * lines[at.z, c] + at.z1 * lines[at.z + 1, c]
    return xy, xz, yz, xt, yt, zt


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def sample(
    plane_cells: Float32Array,  # (B, plane cells, LANES)
    line_cells: Float32Array,  # (B, line cells, LANES)
    resolutions: NDArray[np.int64],  # (L, 3)
    plane_starts: NDArray[np.int64],  # (L, 3)
    line_starts: NDArray[np.int64],  # (L, 3)
    points: Float32Array,  # (N, 3) in [0, 1]
    features: Float32Array,  # (N or more, L * B * LANES), out
) -> None:
    """Products over the six planes, interpolated linearly; features go by level, then block."""
    n_levels = len(resolutions)
    for task in prange(len(plane_cells) * n_levels):
        block, level = task // n_levels, task % n_levels
        cells, lines = plane_cells[block], line_cells[block]
        column = (level * len(plane_cells) + block) * LANES
        for n in range(len(points)):
            at = _place(points[n], resolutions[level], plane_starts[level], line_starts[level])
            for c in range(LANES):
                xy, xz, yz, xt, yt, zt = _values(cells, lines, at, c)
                features[n, column + c] = (xy * xz * yz) * (xt * yt * zt)


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _add(to: Float32Array, cell: int, weight: np.float32, values: Float32Array, row: int) -> None:
    for c in range(LANES):
        to[cell, c] += weight * values[row, c]


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _add_plane(
    to: Float32Array, cell: int, stride: int,
    a0: np.float32, a1: np.float32, b0: np.float32, b1: np.float32, values: Float32Array, row: int,
) -> None:  # fmt: skip
    _add(to, cell, a0 * b0, values, row)
    _add(to, cell + 1, a1 * b0, values, row)
    _add(to, cell + stride, a0 * b1, values, row)
    _add(to, cell + stride + 1, a1 * b1, values, row)


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _add_line(
    to: Float32Array, cell: int, a0: np.float32, a1: np.float32, values: Float32Array, row: int
) -> None:
    _add(to, cell, a0, values, row)
    _add(to, cell + 1, a1, values, row)


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def sample_backward(
    plane_cells: Float32Array,
    line_cells: Float32Array,
    resolutions: NDArray[np.int64],
    plane_starts: NDArray[np.int64],
    line_starts: NDArray[np.int64],
    points: Float32Array,
    seen: NDArray[np.bool_],  # (N,) points with any gradient
    by_features: Float32Array,  # (N or more, L * B * LANES)
    by_planes: Float32Array,  # (B, plane cells, LANES), out
    by_lines: Float32Array,  # (B, line cells, LANES), out
    touched: NDArray[np.bool_],  # (B, plane cells), out: those around a point that is seen
) -> None:
    """Gradients by the cells."""
    n_levels = len(resolutions)
    for task in prange(len(plane_cells) * n_levels):
        block, level = task // n_levels, task % n_levels
        cells, lines = plane_cells[block], line_cells[block]
        to_planes, to_lines, marks = by_planes[block], by_lines[block], touched[block]
        counts = resolutions[level]
        _clear(to_planes, plane_starts[level, 0], plane_starts[level, 2] + counts[1] * counts[2])
        _clear(to_lines, line_starts[level, 0], line_starts[level, 2] + counts[2])
        marks[plane_starts[level, 0] : plane_starts[level, 2] + counts[1] * counts[2]] = False
        column = (level * len(plane_cells) + block) * LANES
        by = np.empty((6, LANES), by_features.dtype)
        for n in range(len(points)):
            if not seen[n]:
                continue
            at = _place(points[n], counts, plane_starts[level], line_starts[level])
            for c in range(LANES):
                xy, xz, yz, xt, yt, zt = _values(cells, lines, at, c)
                by_space = by_features[n, column + c] * (xt * yt * zt)
                by_time = by_features[n, column + c] * (xy * xz * yz)
                by[0, c], by[1, c], by[2, c] = (
                    by_space * (xz * yz),
                    by_space * (xy * yz),
                    by_space * (xy * xz),
                )
                by[3, c], by[4, c], by[5, c] = by_time * yt * zt, by_time * xt * zt, by_time * xt * yt
            _add_plane(to_planes, at.xy, at.across, at.x0, at.x1, at.y0, at.y1, by, 0)
            _add_plane(to_planes, at.xz, at.across, at.x0, at.x1, at.z0, at.z1, by, 1)
            _add_plane(to_planes, at.yz, at.down, at.y0, at.y1, at.z0, at.z1, by, 2)
            _add_line(to_lines, at.x, at.x0, at.x1, by, 3)
            _add_line(to_lines, at.y, at.y0, at.y1, by, 4)
            _add_line(to_lines, at.z, at.z0, at.z1, by, 5)
            for cell in (at.xy, at.xy + at.across, at.xz, at.xz + at.across, at.yz, at.yz + at.down):
                marks[cell] = marks[cell + 1] = True


@njit(forceinline=True, fastmath={"contract"}, error_model="numpy")
def _clear(cells: Float32Array, first: int, end: int) -> None:
    for cell in range(first, end):
        for c in range(LANES):
            cells[cell, c] = ZERO
