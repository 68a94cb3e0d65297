"""Regions of a small copy of the picture: pixels of one kind that are connected by their sides.

What OpenCV has, too; but its calls wake threads of its own, and take longer than the work.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Levels = NDArray[np.uint8]
Numbers = NDArray[np.int32]
Runs = tuple[Numbers, Numbers, Numbers]
"""Regions, in runs of pixels from the top: (n, 2) first column and the one after the last, (h + 1,) the first
run of each row, and (n,) the number of each one's region, from 1 in the order of their first pixels."""
WORD = 8
"""Pixels that are looked at together."""


@njit(error_model="numpy")
def lit_parts(low: Levels, threshold: float) -> tuple[Levels, Runs, NDArray[np.int64]]:
    """(h, w) 1 where `low` is above the threshold, not negative; `Runs` of these regions, once an opening by
    3 x 3 pixels has taken specks; and their `areas_of`.

    All is dark beyond the border: lines along it, as recorders leave them, are as thin as specks.
    """
    lit, once, opened = np.empty_like(low), np.empty_like(low), np.empty_like(low)
    highest = np.uint8(min(np.floor(threshold), 255.0))
    for y in range(low.shape[0]):
        for x in range(low.shape[1]):
            lit[y, x] = np.uint8(1) if low[y, x] > highest else np.uint8(0)
    _spread(lit, 0, once)
    _spread(once, 1, opened)
    runs = connected(opened, 1)
    return lit, runs, areas_of(runs)


@njit(error_model="numpy")
def connected(mask: Levels, kind: int) -> Runs:
    """The regions of a kind, 0 or 1, of which a mask is."""
    runs, rows, parents = _joined(mask, kind)
    numbers, count = np.empty(len(runs), np.int32), 1
    for run in range(len(runs)):
        root = _root(parents, run)
        if root == run:
            numbers[run] = count
            count += 1
        else:
            numbers[run] = numbers[root]
    return runs, rows, numbers


@njit(error_model="numpy")
def areas_of(regions: Runs) -> NDArray[np.int64]:
    """Pixels of each region; 0 of none."""
    runs, _, numbers = regions
    areas = np.zeros(numbers.max() + 1 if len(numbers) > 0 else 1, np.int64)
    for run in range(len(runs)):
        areas[numbers[run]] += runs[run, 1] - runs[run, 0]
    return areas


@njit(cache=True, error_model="numpy")
def drawn(regions: Runs, height: int, width: int) -> Numbers:
    """(h, w) the number of each pixel's region, 0 where there is none."""
    runs, rows, numbers = regions
    labels = np.zeros((height, width), np.int32)
    for y in range(height):
        for run in range(rows[y], rows[y + 1]):
            for x in range(runs[run, 0], runs[run, 1]):
                labels[y, x] = numbers[run]
    return labels


@njit(error_model="numpy")
def ends_of(regions: Runs, are_wanted: NDArray[np.bool_]) -> Numbers:
    """(2 n, 2) first and last pixels, x and y, of the rows that some regions reach into."""
    runs, rows, numbers = regions
    ends, found = np.empty((2 * len(rows), 2), np.int32), 0
    for y in range(len(rows) - 1):
        first, last = rows[y], rows[y + 1] - 1
        while first <= last and not are_wanted[numbers[first]]:
            first += 1
        if first > last:
            continue
        while not are_wanted[numbers[last]]:
            last -= 1
        ends[found, 0], ends[found + 1, 0] = runs[first, 0], runs[last, 1] - 1
        ends[found, 1] = ends[found + 1, 1] = y
        found += 2
    return ends[:found]


@njit(error_model="numpy")
def touching_border(regions: Runs, width: int) -> NDArray[np.bool_]:
    """Which regions of a picture so wide reach its border."""
    runs, rows, numbers = regions
    touches, height = np.zeros(numbers.max() + 1 if len(numbers) > 0 else 1, np.bool_), len(rows) - 1
    for y in range(height):
        for run in range(rows[y], rows[y + 1]):
            if y == 0 or y == height - 1 or runs[run, 0] == 0 or runs[run, 1] == width:
                touches[numbers[run]] = True
    return touches


@njit(error_model="numpy")
def dark_beside_border(lit: Levels, spans: Numbers, lines: Numbers) -> tuple[int, int]:
    """Pixels of the dark regions that touch the border: those within a field, and all.

    spans, lines: runs of the field's pixels, and the first one of each row, as in `Runs`.
    """
    runs, rows, numbers = dark = connected(lit, 0)
    touches, within, reached = touching_border(dark, lit.shape[1]), 0, 0
    for y in range(len(rows) - 1):
        for run in range(rows[y], rows[y + 1]):
            if touches[numbers[run]]:
                reached += runs[run, 1] - runs[run, 0]
                for span in range(lines[y], lines[y + 1]):
                    within += max(min(runs[run, 1], spans[span, 1]) - max(runs[run, 0], spans[span, 0]), 0)
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
def _joined(mask: Levels, kind: int) -> tuple[Numbers, Numbers, Numbers]:
    """Runs and rows as in `Runs`, and (n,) for each run one of its region that comes no later, itself for the
    first."""
    height, width = mask.shape
    runs, rows = np.empty((height * ((width + 1) // 2), 2), np.int32), np.empty(height + 1, np.int32)
    parents, count, before = np.empty(len(runs), np.int32), 0, 0
    # Where a row turns to the kind or from it: most words of eight pixels hold no such place.
    turns = np.zeros((width + WORD) // WORD * WORD, np.uint8)
    words = turns.view(np.uint64)
    for y in range(height):
        _mark_turns(mask[y], kind, turns)
        rows[y], first = count, -1
        for word in range(len(words)):
            if words[word] == 0:
                continue
            for x in range(word * WORD, word * WORD + WORD):
                if turns[x] == 0:
                    continue
                if first < 0:
                    first = x
                    continue
                runs[count, 0], runs[count, 1], parents[count] = first, x, count
                while before < rows[y] and runs[before, 1] <= first:
                    before += 1
                # The last one that reaches here may reach the next run, too.
                beside = before
                while beside < rows[y] and runs[beside, 0] < x:
                    _join(parents, beside, count)
                    beside += 1
                count, first = count + 1, -1
        before = rows[y]
    rows[height] = count
    return runs[:count], rows, parents[:count]


@njit(error_model="numpy")
def _mark_turns(row: Levels, kind: int, turns: Levels) -> None:
    """1 where a row of 0 and 1 turns to a kind or from it, as it does at its ends; one place more than it
    has."""
    last = len(row) - 1
    left, right, marks = row[:last], row[1:], turns[1:]
    turns[0], turns[last + 1] = row[0] == kind, row[last] == kind
    for x in range(last):
        marks[x] = left[x] ^ right[x]


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
