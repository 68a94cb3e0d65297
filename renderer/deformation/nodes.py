"""Motion nodes: a coarse grid over the view whose curves neighbouring Gaussians share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.camera import Camera


def node_grid(camera: Camera, columns: int) -> tuple[int, int]:
    """Columns and rows of the grid: square cells over the whole picture."""
    return columns, max(2, round(columns * camera.height / camera.width))


def attach(
    means: NDArray[np.float32], camera: Camera, grid: tuple[int, int]
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """The four nodes around each mean (N, 4) as `camera` sees it, and their bilinear weights (N, 4).

    Means outside the view hold on to the nodes at its edge. Rows of the weights sum to 1.
    """
    columns, rows = grid
    pixels, _ = camera.project(means.astype(np.float64))
    pixels = np.nan_to_num(pixels, posinf=0.0, neginf=0.0)
    x = np.clip(pixels[:, 0] / camera.width * (columns - 1), 0, columns - 1)
    y = np.clip(pixels[:, 1] / camera.height * (rows - 1), 0, rows - 1)
    column = np.minimum(x.astype(np.int64), columns - 2)
    row = np.minimum(y.astype(np.int64), rows - 2)
    across, down = x - column, y - row
    corner = row * columns + column
    indices = np.stack([corner, corner + 1, corner + columns, corner + columns + 1], axis=1)
    weights = np.stack(
        [(1 - across) * (1 - down), across * (1 - down), (1 - across) * down, across * down], axis=1
    )
    return indices.astype(np.int32), weights.astype(np.float32)


@dataclass(frozen=True, eq=False)
class Attachment:
    """Which Gaussians hold on to each node: the transpose of (indices, weights), node by node."""

    starts: NDArray[np.int64]
    gaussians: NDArray[np.int32]
    weights: NDArray[np.float32]

    @classmethod
    def transposed(cls, indices: NDArray[np.int32], weights: NDArray[np.float32], n_nodes: int) -> Attachment:
        order = np.argsort(indices, axis=None, kind="stable")
        starts = np.zeros(n_nodes + 1, np.int64)
        np.cumsum(np.bincount(indices.ravel(), minlength=n_nodes), out=starts[1:])
        return cls(starts, (order // 4).astype(np.int32), weights.ravel()[order])


@njit(parallel=True, cache=True)
def add_shared(
    nodes: NDArray[np.float32],  # (M, C)
    indices: NDArray[np.int32],  # (N, 4)
    weights: NDArray[np.float32],  # (N, 4)
    out: NDArray[np.float32],  # (N, C), added to
) -> None:
    """Give every Gaussian the weighted values of its nodes."""
    for n in prange(indices.shape[0]):
        for c in range(nodes.shape[1]):
            value = np.float32(0.0)
            for corner in range(4):
                value += weights[n, corner] * nodes[indices[n, corner], c]
            out[n, c] += value


@njit(parallel=True, cache=True)
def gather_gradients(
    starts: NDArray[np.int64],
    gaussians: NDArray[np.int32],
    weights: NDArray[np.float32],
    gradients: NDArray[np.float32],  # (N, C)
    out: NDArray[np.float32],  # (M, C)
    touched: NDArray[np.bool_],  # (M,), out: nodes with any gradient
) -> None:
    """Backward of `add_shared`, summed in a fixed order for each node."""
    for m in prange(len(touched)):
        touched[m] = False
        for c in range(out.shape[1]):
            value = np.float32(0.0)
            for i in range(starts[m], starts[m + 1]):
                value += weights[i] * gradients[gaussians[i], c]
            out[m, c] = value
            touched[m] |= value != 0
