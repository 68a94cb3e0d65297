"""The zero level of a volume as a mesh: one vertex a cell that it crosses (Gibson, MICCAI 1998)."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from renderer.splats import Float32Array
from renderer.surface.fusion import TRUNCATED, Volume
from renderer.surface.mesh import Mesh

Cells = NDArray[np.int64]
CORNERS = tuple(itertools.product((0, 1), repeat=3))
EDGES = tuple(
    (one, other)
    for one, other in itertools.combinations(CORNERS, 2)
    if sum(a != b for a, b in zip(one, other, strict=True)) == 1
)


def surface_net(volume: Volume) -> Mesh:
    """Where all corners of a cell are known and near the surface; elsewhere it has holes. Grey."""
    values = volume.distances
    known = (volume.weights > 0) & (np.abs(values) < TRUNCATED)
    cells = tuple(size - 1 for size in values.shape)
    whole = np.ones(cells, bool)
    below = np.zeros(cells, np.int8)
    for corner in CORNERS:
        whole &= _at(known, corner)
        below += _at(values, corner) < 0
    crossed = whole & (below > 0) & (below < len(CORNERS))
    number = np.full(cells, -1, np.int64)
    number[crossed] = np.arange(np.count_nonzero(crossed))
    vertices = volume.origin + volume.voxel * _crossings(values, np.argwhere(crossed))
    faces = np.concatenate([_faces(values, number, axis) for axis in range(3)]).astype(np.int32)
    grey = np.full((len(vertices), 3), 0.5, np.float32)
    return Mesh(vertices.astype(np.float32), faces, grey)


def _at(values: NDArray[Any], corner: tuple[int, ...]) -> NDArray[Any]:
    """Of each cell the value at this corner."""
    return values[tuple(slice(at, size - 1 + at) for at, size in zip(corner, values.shape, strict=True))]


def _crossings(values: Float32Array, cells: Cells) -> NDArray[np.float64]:
    """(N, 3) mean of the places, in voxels, at which the level crosses the edges of each cell (N, 3)."""
    total, count = np.zeros((len(cells), 3)), np.zeros((len(cells), 1))
    for one, other in EDGES:
        first, second = (values[tuple((cells + corner).T)].astype(np.float64) for corner in (one, other))
        crosses = (first < 0) != (second < 0)
        share = np.divide(first, first - second, out=np.zeros_like(first), where=crosses)
        place = np.add(one, share[:, None] * np.subtract(other, one))
        total += np.where(crosses[:, None], place, 0)
        count += crosses[:, None]
    return np.asarray(cells + total / np.maximum(count, 1))


def _faces(values: Float32Array, number: Cells, axis: int) -> Cells:
    """(F, 3) of the edges along an axis that the level crosses: two a square of four cells around each."""
    ahead = np.moveaxis(values, axis, 0)
    cells = np.moveaxis(number, axis, 0)
    inner = ahead[:, 1:-1, 1:-1]
    crosses = (inner[:-1] < 0) != (inner[1:] < 0)
    a, b, c, d = cells[:, :-1, :-1], cells[:, 1:, :-1], cells[:, :-1, 1:], cells[:, 1:, 1:]
    wanted = crosses & (a >= 0) & (b >= 0) & (c >= 0) & (d >= 0)
    square = np.stack([corner[wanted] for corner in (a, b, d, c)], axis=1)
    # Turned so that the front is where distances are positive; the middle axis runs the other way round.
    turned = (inner[:-1][wanted] < 0) != (axis == 1)
    square[~turned] = square[~turned][:, ::-1]
    return np.concatenate([square[:, [0, 1, 2]], square[:, [0, 2, 3]]])
