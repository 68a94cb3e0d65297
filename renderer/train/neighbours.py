"""The points nearest to each of many, and how far they lie: the size that Gaussians need to close gaps."""

from __future__ import annotations

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

NEIGHBOURS = 3


def neighbour_distances(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """Root mean square distance of each point (N, 3) to its 3 nearest others (Kerbl et al. 2023, 5.1).

    With fewer than three others it is of those there are, and 0 for a single point.
    """
    squares, _ = nearest_others(points, NEIGHBOURS)
    total = np.zeros(len(points), np.float32)
    for square in squares.T:
        total += square
    distances: NDArray[np.float32] = np.sqrt(total / np.float32(max(len(squares.T), 1)))
    return distances


def nearest_others(points: NDArray[np.float32], count: int) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Ascending squared distances of each point (N, 3) to its `count` nearest others, or to all of fewer, and
    which these are.

    Exact: a sweep from each point both ways along the axis on which the points spread most, until the
    next one is farther on that axis alone than the farthest of those wanted.
    """
    wanted = max(min(count, len(points) - 1), 0)
    squares, others = np.empty((len(points), wanted), np.float32), np.empty((len(points), wanted), np.int64)
    if wanted:
        spread = np.subtract(*np.percentile(points, (90, 10), axis=0))
        axis = int(np.argmax(spread))
        order = np.argsort(points[:, axis], kind="stable")
        found, places = np.full_like(squares, np.inf), np.zeros_like(others)
        _sweep(np.ascontiguousarray(points[order]), axis, found, places)
        squares[order], others[order] = found, order[places]
    return squares, others


@njit(parallel=True, cache=True)
def _sweep(
    points: NDArray[np.float32],  # (N, 3), ascending along the axis
    axis: int,
    squares: NDArray[np.float32],  # (N, K), infinite; out: squared distances to the nearest
    others: NDArray[np.int64],  # (N, K), out: which these are
) -> None:
    for n in prange(len(points)):
        for step in (-1, 1):
            other = n + step
            while 0 <= other < len(points):
                away = points[other, axis] - points[n, axis]
                if away * away >= squares[n, -1]:
                    break
                _insert(squares[n], others[n], _square(points, n, other), other)
                other += step


@njit(forceinline=True)
def _square(points: NDArray[np.float32], a: int, b: int) -> np.float32:
    total = np.float32(0.0)
    for c in range(3):
        total += (points[a, c] - points[b, c]) * (points[a, c] - points[b, c])
    return total


@njit(forceinline=True)
def _insert(nearest: NDArray[np.float32], which: NDArray[np.int64], value: np.float32, other: int) -> None:
    """Into an ascending list, whose largest drops out."""
    for k in range(len(nearest)):
        if value < nearest[k]:
            nearest[k], value = value, nearest[k]
            which[k], other = other, which[k]
