"""Self-guided fast guided filter (Eqs 3-6; He and Sun, "Fast Guided Filter", arXiv 1505.00996, 2015).

Their code takes the variance of block means and rounds r / s. Here a window on a grid keeps the variance that
the image has in it, and its width to a fraction: several times closer to the filter without a grid, so that
large windows can do with a coarser one.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.part import part
from enhance.pixel_block import copy_row
from enhance.prefetch import fetch_row
from enhance.wide_vectors import wide_vectors
from enhance.window_rows import (
    EDGE,
    NARROW,
    accumulate,
    describe,
    describe_narrow,
    mean_narrow,
    mean_of,
)

STRIP: Final = 48
"""Rows of one task at most, beside twice its windows' reach. It does not depend on the number of threads, so
that no result does."""
SPAN: Final = 8
"""Pixels of the coarse grid that a window must be wide to be put there. With so many the default scales stay
within 0.05 grey levels of no grid on training frames, SCARED and retina pictures."""

# What is done with the variance and mean of a scale's windows, which do not depend on eps.
PASS, KEEP, TAKE = range(3)


class Window(NamedTuple):
    """A scale's window on its grid, whose pixels are blocks of the image."""

    subsample: int
    """Image pixels along a side of the fine grid's blocks."""
    coarse: bool
    """On the coarse grid, whose blocks are twice as large."""
    whole: int
    """Grid pixels on each side of the middle one that count in full."""
    part: float
    """Weight, in [0, 1), of the next ones."""
    eps: float
    """Of Eq 4, a variance on [0, 1]."""


Windows = tuple[Window, ...]


class Grids(NamedTuple):
    """The same of both grids; the last two axes are (h, w) and (h / 2, w / 2), odd sizes rounded up."""

    fine: NDArray[np.float32]
    coarse: NDArray[np.float32]
    """Of no pixels when the fine grid is the image itself."""


def window(radius: int, eps: float, subsample: int) -> Window:
    """The window of 2 r + 1 image pixels, on the coarse grid if it spans enough of that."""
    coarse = subsample > 1 and 2 * radius + 1 >= SPAN * 2 * subsample
    return window_on(radius, eps, subsample, coarse)


def window_on(radius: int, eps: float, subsample: int, coarse: bool) -> Window:
    """The window on a grid, (2 r + 1) / s of its pixels wide but at least one."""
    grid = 2 * subsample if coarse else subsample
    beyond = max(2 * radius + 1 - grid, 0)
    return Window(subsample, coarse, beyond // (2 * grid), beyond % (2 * grid) / (2 * grid), eps)


@lru_cache(maxsize=64)
def windows_of(radii: tuple[int, ...], eps: float, subsample: int) -> Windows:
    """`window` of each radius."""
    return tuple(window(radius, eps, subsample) for radius in radii)


@lru_cache(maxsize=64)
def are_coarse(windows: Windows) -> NDArray[np.bool_]:
    """(n,) which are on the coarse grid; not to be written to."""
    return np.array([one.coarse for one in windows])


class WindowModels:
    """The linear models of several scales, in memory that stays; only what changed is computed again.

    From the second time on that only eps has moved, so does only what depends on it.
    """

    def __init__(self) -> None:
        self._done: list[Window | None] = []
        self._kept_of: list[Window | None] = []
        self._models = self._kept = _memory([(0, 2, 0, 0)] * 2)

    def forget(self) -> None:
        """The next image is another one."""
        self._done = [None] * len(self._done)
        self._kept_of = [None] * len(self._done)

    @property
    def memory(self) -> tuple[NDArray[np.float32], ...]:
        """What stays."""
        return (*self._models, *(self._kept if self._kept is not self._models else ()))

    def of(self, low: Grids, windows: Windows, needed: Sequence[bool]) -> Grids:
        """Window means of a and b (Eqs 4 and 5, averaged for Eq 6); guide and input are the same.

        Args:
            low: (2, h, w): mean of V in each block, and its variance there; windows count what is inside.
            windows: one for each scale.
            needed: the scales to compute.

        Returns:
            (n_scales, 2, h, w), overwritten by the next call: a, near 1 at edges, which stay, and near 0 on
            flat parts, which are smoothed; and b. Both in [0, 1]. A needed scale has them on its own grid.
        """
        shapes = [(len(windows), *plane.shape) for plane in low]
        if [plane.shape for plane in self._models] != shapes:
            self._models = self._kept = _memory(shapes)
            self._done, self._kept_of = [None] * len(windows), [None] * len(windows)
        stale = [i for i, one in enumerate(windows) if needed[i] and self._done[i] != one]
        if stale:
            plan = _plan(windows, low.fine.shape, low.coarse.shape)
            stages = np.array([self._stage(i, one) if i in stale else PASS for i, one in enumerate(windows)])
            tasks = _tasks(plan.rows, tuple(stale), plan.coarse, plan.whole)
            coarse, whole = are_coarse(windows), np.array(plan.whole)
            _fit(*low, tasks, coarse, whole, plan.part, plan.eps, stages, *self._kept, *self._models)
            for i in stale:
                self._done[i] = windows[i]
        return self._models

    def _stage(self, index: int, now: Window) -> int:
        before = self._done[index]
        if before is None and self._kept_of[index] is None:
            return PASS
        anyhow = now._replace(eps=0.0)
        if self._kept_of[index] == anyhow:
            return TAKE
        if before is None or before._replace(eps=0.0) != anyhow:
            return PASS
        if self._kept is self._models:
            self._kept = _memory([plane.shape for plane in self._models])
        self._kept_of[index] = anyhow
        return KEEP


class _Plan(NamedTuple):
    """What `_fit` is told of the windows on grids of some size."""

    rows: tuple[int, ...]
    """Of each scale's grid."""
    coarse: tuple[bool, ...]
    whole: tuple[int, ...]
    """No more than the grid has."""
    part: NDArray[np.float64]
    """As eps, not to be written to."""
    eps: NDArray[np.float64]


@lru_cache(maxsize=64)
def _plan(windows: Windows, fine: tuple[int, ...], coarse: tuple[int, ...]) -> _Plan:
    """fine, coarse: shapes of the grids."""
    on_coarse = tuple(one.coarse for one in windows)
    whole = tuple(min(one.whole, max(fine)) for one in windows)
    rows = tuple(coarse[1] if one.coarse else fine[1] for one in windows)
    part, eps = np.array([one.part for one in windows]), np.array([one.eps for one in windows])
    return _Plan(rows, on_coarse, whole, part, eps)


def _memory(shapes: Sequence[tuple[int, ...]]) -> Grids:
    return Grids(*(np.empty(shape, np.float32) for shape in shapes))


@lru_cache(maxsize=64)
def _tasks(
    rows: tuple[int, ...], scales: tuple[int, ...], coarse: tuple[bool, ...], whole: tuple[int, ...]
) -> NDArray[np.int64]:
    """(n, 3) scale, first row and the row after the last of each strip, from the top of the image down."""
    tasks = []
    for scale in scales:
        count = -(-rows[scale] // (STRIP + 2 * whole[scale]))
        cuts = [rows[scale] * index // count for index in range(count + 1)]
        tasks += [(scale, top, bottom) for top, bottom in pairwise(cuts)]
    return np.array(sorted(tasks, key=lambda task: task[1] * (1 + coarse[task[0]])), dtype=np.int64)


@njit(parallel=True, nogil=True, cache=True, fastmath={"contract"}, error_model="numpy")
def _fit(
    fine: NDArray[np.float32],  # (2, h, w) block means and variances
    coarse: NDArray[np.float32],
    tasks: NDArray[np.int64],  # (n, 3) scale, first row, row after the last
    is_coarse: NDArray[np.bool_],  # of each scale
    whole: NDArray[np.int64],
    part: NDArray[np.float64],
    eps: NDArray[np.float64],
    stages: NDArray[np.int64],  # PASS, KEEP or TAKE
    fine_kept: NDArray[np.float32],  # (n, 2, h, w), in or out: variance and mean of the windows
    coarse_kept: NDArray[np.float32],
    fine_out: NDArray[np.float32],  # (n, 2, h, w), out: window means of a and b
    coarse_out: NDArray[np.float32],
) -> None:
    """Each strip has its own models of the windows around it, so that those of no more rows are in memory."""
    for task in prange(len(tasks)):
        scale, top, bottom = tasks[task]
        low = coarse if is_coarse[scale] else fine
        kept = coarse_kept[scale] if is_coarse[scale] else fine_kept[scale]
        out = coarse_out[scale] if is_coarse[scale] else fine_out[scale]
        rows, columns = low.shape[1:]
        reach = whole[scale]
        before, after = max(top - reach - 1, 0), min(bottom + reach + 1, rows)
        _fit_strip(
            low,
            (top, bottom, before, after),
            reach,
            part[scale],
            np.float32(eps[scale]),
            stages[scale],
            kept,
            out,
            np.empty((2, after - before, columns), np.float32),
            np.zeros((2, columns + 2 * EDGE)),
            np.empty((2, columns + 2 * reach + 3)),
            _shares(columns, reach, part[scale]),
        )


@part(fastmath={"contract"})
def _fit_strip(
    low: NDArray[np.float32],
    ends: tuple[int, int, int, int],  # first row and row after the last, and those of models that they need
    reach: int,
    rest: float,
    eps: np.float32,
    stage: int,
    kept: NDArray[np.float32],
    out: NDArray[np.float32],
    models: NDArray[np.float32],
    sums: NDArray[np.float64],
    running: NDArray[np.float64],
    shares: NDArray[np.float64],
) -> None:
    """One task; `models`, `sums` and `running` are memory to work in."""
    top, bottom, before, after = ends
    rows, columns = low.shape[1:]
    first, second = sums[0][EDGE : columns + EDGE], sums[1][EDGE : columns + EDGE]
    for y in range(before, after):
        variance, mean = models[0, y - before], models[1, y - before]
        if stage == TAKE:
            copy_row(kept[0, y], variance)
            copy_row(kept[1, y], mean)
        else:
            _move(low, True, y, y == before, reach, rest, first, second)
            tall = 1.0 / _covered(y, rows, reach, rest)
            if reach == NARROW:
                describe_narrow(sums[0], sums[1], rest, shares, tall, variance, mean)
            else:
                accumulate(first, second, reach, running)
                describe(running[0], running[1], reach, rest, shares, tall, variance, mean)
        if stage == KEEP and top <= y < bottom:
            copy_row(variance, kept[0, y])
            copy_row(mean, kept[1, y])
        _solve(eps, variance, mean)
    for y in range(top, bottom):
        tall = 1.0 / _covered(y, rows, reach, rest)
        _move(models, False, y - before, y == top, reach, rest, first, second)
        for plane in range(2):
            fetch_row(out[plane], y + 1)
        if reach == NARROW:
            for plane in range(2):
                mean_narrow(sums[plane], rest, shares, tall, out[plane, y])
        else:
            accumulate(first, second, reach, running)
            for plane in range(2):
                mean_of(running[plane], reach, rest, shares, tall, out[plane, y])


@part()
def _covered(at: int, size: int, whole: int, part: float) -> float:
    """Weight of the part of a window around `at` that lies inside the image, along one axis."""
    inside = min(at + whole, size - 1) - max(at - whole, 0) + 1
    partly = (1 if at - whole > 0 else 0) + (1 if at + whole < size - 1 else 0)
    return float(inside) + part * partly


@njit(error_model="numpy")
def _shares(columns: int, whole: int, part: float) -> NDArray[np.float64]:
    """(columns,) one over the weight of the columns that each window covers."""
    wide_vectors()
    out = np.empty(columns)
    for x in range(columns):
        out[x] = 1.0 / _covered(x, columns, whole, part)
    return out


@part()
def _move(
    planes: NDArray[np.float32],  # (2, h, w)
    moments: bool,  # the planes are means and variances: sum V and V^2 of what they are of
    y: int,
    begins: bool,
    whole: int,
    part: float,
    first: NDArray[np.float64],  # (w,), in and out: over the rows of the windows of row y - 1, then of row y
    second: NDArray[np.float64],
) -> None:
    """Two rows come in by and by, and two go; to begin with, all come in, four at a time."""
    wide_vectors()
    if begins:
        first[:] = 0.0
        second[:] = 0.0
        for row in range(max(y - whole - 1, 0), min(y + whole + 2, planes.shape[1]), 4):
            _add(planes, moments, (row, row + 1, row + 2, row + 3), y, begins, whole, part, first, second)
    else:
        rows = (y - whole - 2, y - whole - 1, y + whole, y + whole + 1)
        _add(planes, moments, rows, y, begins, whole, part, first, second)
        if moments:
            for plane in range(2):
                fetch_row(planes[plane], y + whole + 2)


@part(fastmath={"contract"})
def _add(
    planes: NDArray[np.float32],
    moments: bool,
    rows: tuple[int, int, int, int],
    y: int,
    begins: bool,
    whole: int,
    part: float,
    first: NDArray[np.float64],
    second: NDArray[np.float64],
) -> None:
    wide_vectors()
    height = planes.shape[1]
    y0, w0 = _change(rows[0], y, begins, height, whole, part)
    y1, w1 = _change(rows[1], y, begins, height, whole, part)
    y2, w2 = _change(rows[2], y, begins, height, whole, part)
    y3, w3 = _change(rows[3], y, begins, height, whole, part)
    m0, m1, m2, m3 = planes[0, y0], planes[0, y1], planes[0, y2], planes[0, y3]
    v0, v1, v2, v3 = planes[1, y0], planes[1, y1], planes[1, y2], planes[1, y3]
    for x in range(len(first)):
        above = w0 * np.float64(m0[x]) + w1 * np.float64(m1[x])
        first[x] += above + (w2 * np.float64(m2[x]) + w3 * np.float64(m3[x]))
    if moments:
        for x in range(len(second)):
            f0, f1, f2, f3 = np.float64(m0[x]), np.float64(m1[x]), np.float64(m2[x]), np.float64(m3[x])
            above = w0 * (f0 * f0 + np.float64(v0[x])) + w1 * (f1 * f1 + np.float64(v1[x]))
            below = w2 * (f2 * f2 + np.float64(v2[x])) + w3 * (f3 * f3 + np.float64(v3[x]))
            second[x] += above + below
    else:
        for x in range(len(second)):
            above = w0 * np.float64(v0[x]) + w1 * np.float64(v1[x])
            second[x] += above + (w2 * np.float64(v2[x]) + w3 * np.float64(v3[x]))


@part()
def _change(row: int, y: int, begins: bool, height: int, whole: int, part: float) -> tuple[int, float]:
    """A row that exists, and how much more `row` counts for row y than it did for y - 1, or than nothing."""
    if row < 0 or row >= height:
        return 0, 0.0
    gained = _weight(row - y, whole, part)
    return row, gained if begins else gained - _weight(row - y + 1, whole, part)


@part()
def _weight(apart: int, whole: int, part: float) -> float:
    return 1.0 if abs(apart) <= whole else part if abs(apart) == whole + 1 else 0.0


@part(fastmath={"contract"})
def _solve(eps: np.float32, first: NDArray[np.float32], second: NDArray[np.float32]) -> None:
    """Variance and mean become a and b; (1 - a) as eps / (variance + eps), which does not cancel."""
    wide_vectors()
    for x in range(len(first)):
        smooth = eps / (first[x] + eps)
        first[x] = np.float32(1.0) - smooth
        second[x] *= smooth
