"""Regions of a small copy of the picture: pixels of one kind that are connected by their sides.

What OpenCV has, too; but its calls wake threads of its own, and take longer than the work.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Levels = NDArray[np.uint8]
Numbers = NDArray[np.int32]


@njit(error_model="numpy")
def lit_parts(low: Levels, threshold: float) -> tuple[Levels, Numbers, int]:
    """(h, w) 1 where `low` is above the threshold; (h, w) labels of its regions, from 1 in the order of their
    first pixels, once an opening by 3 x 3 pixels has taken specks; and one more than there are of these.

    All is dark beyond the border: lines along it, as recorders leave them, are as thin as specks.
    """
    lit, once, opened = np.empty_like(low), np.empty_like(low), np.empty_like(low)
    for y in range(low.shape[0]):
        for x in range(low.shape[1]):
            lit[y, x] = np.uint8(1) if low[y, x] > threshold else np.uint8(0)
    _spread(lit, 0, once)
    _spread(once, 1, opened)
    runs, rows, parents = _connected(opened, 1)
    labels, numbers, count = np.zeros(low.shape, np.int32), np.empty(len(runs), np.int32), 1
    for y in range(low.shape[0]):
        for run in range(rows[y], rows[y + 1]):
            root = _root(parents, run)
            if root == run:
                numbers[run] = count
                count += 1
            labels[y, runs[run, 0] : runs[run, 1]] = numbers[root]
    return lit, labels, count


@njit(cache=True, error_model="numpy")
def dark_beside_border(lit: Levels, field: Levels) -> tuple[int, int]:
    """Pixels of the dark regions that touch the border: those within the field, and all."""
    height, width = lit.shape
    runs, rows, parents = _connected(lit, 0)
    touches = np.zeros(len(runs), np.bool_)
    for y in range(height):
        for run in range(rows[y], rows[y + 1]):
            if y == 0 or y == height - 1 or runs[run, 0] == 0 or runs[run, 1] == width:
                touches[_root(parents, run)] = True
    within, reached = 0, 0
    for y in range(height):
        for run in range(rows[y], rows[y + 1]):
            if touches[_root(parents, run)]:
                reached += runs[run, 1] - runs[run, 0]
                for x in range(runs[run, 0], runs[run, 1]):
                    within += field[y, x] > 0
    return within, reached


@njit(error_model="numpy")
def _spread(mask: Levels, kind: int, out: Levels) -> None:
    """Pixels of a kind, 0 or 1, take those around them; beyond the border all are 0."""
    height, width = mask.shape
    line, beyond = np.zeros(width + 2, np.uint8), np.zeros(width, np.uint8)
    middle = line[1:]
    for y in range(height):
        here = mask[y]
        above, below = mask[y - 1] if y > 0 else beyond, mask[y + 1] if y + 1 < height else beyond
        left, right, row = line, line[2:], out[y]
        if kind == 0:
            for x in range(width):
                middle[x] = here[x] & above[x] & below[x]
            for x in range(width):
                row[x] = left[x] & middle[x] & right[x]
        else:
            for x in range(width):
                middle[x] = here[x] | above[x] | below[x]
            for x in range(width):
                row[x] = left[x] | middle[x] | right[x]


@njit(error_model="numpy")
def _connected(mask: Levels, kind: int) -> tuple[Numbers, Numbers, Numbers]:
    """Runs of a kind, from the top: (n, 2) first column and the one after the last, (h + 1,) the first run of
    each row, and (n,) for each run one of its region that comes no later, itself for the first."""
    height, width = mask.shape
    runs, rows = np.empty((height * ((width + 1) // 2), 2), np.int32), np.empty(height + 1, np.int32)
    parents, count, before = np.empty(len(runs), np.int32), 0, 0
    for y in range(height):
        rows[y], x = count, 0
        while x < width:
            if mask[y, x] != kind:
                x += 1
                continue
            first = x
            while x < width and mask[y, x] == kind:
                x += 1
            runs[count, 0], runs[count, 1], parents[count] = first, x, count
            while before < rows[y] and runs[before, 1] <= first:
                before += 1
            # The last one that reaches here may reach the next run, too.
            beside = before
            while beside < rows[y] and runs[beside, 0] < x:
                _join(parents, beside, count)
                beside += 1
            count += 1
        before = rows[y]
    rows[height] = count
    return runs[:count], rows, parents[:count]


@njit(error_model="numpy")
def _root(parents: Numbers, run: int) -> int:
    while parents[run] != run:
        parents[run] = parents[parents[run]]
        run = parents[run]
    return run


@njit(error_model="numpy")
def _join(parents: Numbers, one: int, other: int) -> None:
    one, other = _root(parents, one), _root(parents, other)
    if one < other:
        parents[other] = one
    else:
        parents[one] = other
