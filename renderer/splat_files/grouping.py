"""Many rows of numbers as few: groups of those that are alike, split where they differ most."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
Places = NDArray[np.int64]


def grouped(rows: NDArray[np.float32], most: int) -> tuple[Values, Places]:
    """The means (K, D) of at most so many groups of rows (N, D), and the group (N,) of each row.

    Each round splits the groups with the largest squared distances to their mean, at the mean of the
    column in which these are largest: rows apart end up alone, and the same rows give the same groups.
    """
    group, count = np.zeros(len(rows), np.int64), min(1, len(rows))
    while count < most:
        means, spread = _spread(rows, group, count)
        column = spread.argmax(axis=1)
        wide = spread.sum(axis=1)
        chosen = np.argsort(-wide, kind="stable")[: most - count]
        chosen = chosen[wide[chosen] > 0]
        successor = np.full(count, -1)
        successor[chosen] = count + np.arange(len(chosen))
        value = rows[np.arange(len(rows)), column[group]]
        moves = (successor[group] >= 0) & (value > means[group, column[group]])
        group = np.where(moves, successor[group], group)
        # Rounding may leave all rows of a group on one side.
        _, group = np.unique(group, return_inverse=True)
        grown = int(group.max(initial=-1)) + 1
        if grown == count:
            break
        count = grown
    return _spread(rows, group, count)[0], group


def _spread(rows: NDArray[np.float32], group: Places, count: int) -> tuple[Values, Values]:
    """Means (K, D) of groups, and sums (K, D) of squared distances to them."""
    held = np.bincount(group, minlength=count)
    means, spread = (np.empty((count, rows.shape[1])) for _ in range(2))
    for place, column in enumerate(rows.T):
        exact = column.astype(np.float64)
        means[:, place] = np.bincount(group, exact, count) / held
        spread[:, place] = np.bincount(group, np.square(exact - means[group, place]), count)
    return means, spread
