"""How far apart points lie: the size that Gaussians need to close the gaps between them."""

from __future__ import annotations

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

NEIGHBOURS = 3


def neighbour_distances(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """Root mean square distance of each point (N, 3) to its 3 nearest others (Kerbl et al. 2023, 5.1).

    Exact: a sweep from each point both ways along the axis on which the points spread most, until the
    next one is farther on that axis alone than the third nearest. With fewer than three others it is
    of those there are, and 0 for a single point.
    """
    if len(points) < 2:
        return np.zeros(len(points), np.float32)
    spread = np.subtract(*np.percentile(points, (90, 10), axis=0))
    axis = int(np.argmax(spread))
    order = np.argsort(points[:, axis], kind="stable")
    squares = np.empty(len(points), np.float32)
    _sweep(np.ascontiguousarray(points[order]), axis, min(NEIGHBOURS, len(points) - 1), squares)
    distances = np.empty_like(squares)
    distances[order] = np.sqrt(squares)
    return distances


@njit(parallel=True, cache=True)
def _sweep(
    points: NDArray[np.float32],  # (N, 3), ascending along the axis
    axis: int,
    wanted: int,
    squares: NDArray[np.float32],  # (N,), out: mean squared distance to the nearest
) -> None:
    for n in prange(len(points)):
        nearest = np.full(NEIGHBOURS, np.float32(np.inf))
        for step in (-1, 1):
            other = n + step
            while 0 <= other < len(points):
                away = points[other, axis] - points[n, axis]
                if away * away >= nearest[wanted - 1]:
                    break
                _insert(nearest, _square(points, n, other))
                other += step
        total = np.float32(0.0)
        for k in range(wanted):
            total += nearest[k]
        squares[n] = total / np.float32(wanted)


@njit(forceinline=True)
def _square(points: NDArray[np.float32], a: int, b: int) -> np.float32:
    total = np.float32(0.0)
    for c in range(3):
        total += (points[a, c] - points[b, c]) * (points[a, c] - points[b, c])
    return total


@njit(forceinline=True)
def _insert(nearest: NDArray[np.float32], value: np.float32) -> None:
    """Into an ascending list, whose largest drops out."""
    for k in range(NEIGHBOURS):
        if value < nearest[k]:
            nearest[k], value = value, nearest[k]
