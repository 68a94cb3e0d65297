"""Self-guided fast guided filter (Eqs 3-6; He and Sun, "Fast Guided Filter", arXiv 1505.00996, 2015)."""

from __future__ import annotations

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.image import Float32Image

Windows = tuple[tuple[int, float, int], ...]
"""Of each scale: radius in pixels of the low resolution; eps, a variance on [0, 1]; subsample."""

STRIP = 32
"""Rows of one task. A fixed number, so that results do not depend on the number of threads."""


def shrunk_radius(radius: int, subsample: int) -> int:
    """r / s as a whole number of low-resolution pixels, halves up, at least 1."""
    return max(1, (2 * radius + subsample) // (2 * subsample))


class WindowModels:
    """The linear models of several scales, in memory that stays; only what changed is computed again."""

    def __init__(self) -> None:
        self._done: list[tuple[int, float, int] | None] = []
        self._single = self._means = np.empty((0, 2, 0, 0), np.float32)

    def forget(self) -> None:
        """The next image is another one."""
        self._done = [None] * len(self._done)

    def of(self, low: Float32Image, windows: Windows) -> NDArray[np.float32]:
        """Window means of a and b (Eqs 4 and 5, averaged for Eq 6); guide and input are the same.

        Args:
            low: subsampled V, (h, w) in [0, 1]; windows count only what is inside.
            windows: one for each scale.

        Returns:
            (n_scales, 2, h, w), overwritten by the next call: a, near 1 at edges, which stay, and near 0 on
            flat parts, which are smoothed; and b. Both in [0, 1].
        """
        shape = (len(windows), 2, *low.shape)
        if self._means.shape != shape:
            self._single, self._means = np.empty(shape, np.float32), np.empty(shape, np.float32)
            self._done = [None] * len(windows)
        slots = np.array([i for i, window in enumerate(windows) if self._done[i] != window], dtype=np.int64)
        if len(slots) > 0:
            # A radius of the longer side less 1 sees all of the image.
            reach = np.array([min(radius, max(low.shape) - 1) for radius, _, _ in windows], dtype=np.int64)
            eps = np.array([eps for _, eps, _ in windows], dtype=np.float32)
            _fit(low, slots, reach, eps, self._single)
            _smooth(self._single, slots, reach, self._means)
            self._done = list(windows)
        return self._means


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def _fit(
    low: NDArray[np.float32],  # (h, w)
    slots: NDArray[np.int64],  # which of the scales
    radii: NDArray[np.int64],  # (n,)
    eps: NDArray[np.float32],  # (n,)
    out: NDArray[np.float32],  # (n, 2, h, w), out: a and b of each window
) -> None:
    rows, columns = low.shape
    strips = (rows + STRIP - 1) // STRIP
    for task in prange(strips * len(slots)):
        scale, top = slots[task % len(slots)], task // len(slots) * STRIP
        radius = radii[scale]
        first, second = np.zeros(columns), np.zeros(columns)
        running_first, running_second = np.empty(columns + 2 * radius + 1), np.empty(columns + 2 * radius + 1)
        shares = _shares(columns, radius)
        for y in range(max(top - radius, 0), min(top + radius, rows)):
            _add_moments(low[y], 1.0, first, second)
        for y in range(top, min(top + STRIP, rows)):
            if y + radius < rows:
                _add_moments(low[y + radius], 1.0, first, second)
            _accumulate(first, second, radius, running_first, running_second)
            tall = 1.0 / np.float64(min(y + radius, rows - 1) - max(y - radius, 0) + 1)
            _solve(
                running_first,
                running_second,
                radius,
                shares,
                tall,
                eps[scale],
                out[scale, 0, y],
                out[scale, 1, y],
            )
            if y - radius >= 0:
                _add_moments(low[y - radius], -1.0, first, second)


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def _smooth(
    single: NDArray[np.float32],  # (n, 2, h, w)
    slots: NDArray[np.int64],  # which of the scales
    radii: NDArray[np.int64],  # (n,)
    out: NDArray[np.float32],  # (n, 2, h, w), out: window means
) -> None:
    rows, columns = single.shape[2], single.shape[3]
    strips = (rows + STRIP - 1) // STRIP
    for task in prange(strips * len(slots)):
        scale, top = slots[task % len(slots)], task // len(slots) * STRIP
        radius = radii[scale]
        a, b = single[scale, 0], single[scale, 1]
        first, second = np.zeros(columns), np.zeros(columns)
        running_first, running_second = np.empty(columns + 2 * radius + 1), np.empty(columns + 2 * radius + 1)
        shares = _shares(columns, radius)
        for y in range(max(top - radius, 0), min(top + radius, rows)):
            _add(a[y], 1.0, first)
            _add(b[y], 1.0, second)
        for y in range(top, min(top + STRIP, rows)):
            if y + radius < rows:
                _add(a[y + radius], 1.0, first)
                _add(b[y + radius], 1.0, second)
            _accumulate(first, second, radius, running_first, running_second)
            tall = 1.0 / np.float64(min(y + radius, rows - 1) - max(y - radius, 0) + 1)
            _mean(running_first, radius, shares, tall, out[scale, 0, y])
            _mean(running_second, radius, shares, tall, out[scale, 1, y])
            if y - radius >= 0:
                _add(a[y - radius], -1.0, first)
                _add(b[y - radius], -1.0, second)


@njit(error_model="numpy")
def _shares(columns: int, radius: int) -> NDArray[np.float64]:
    """(columns,) one over the number of columns that each window covers."""
    out = np.empty(columns)
    for x in range(columns):
        out[x] = 1.0 / (min(x + radius, columns - 1) - max(x - radius, 0) + 1)
    return out


@njit(error_model="numpy")
def _add(row: NDArray[np.float32], sign: float, sums: NDArray[np.float64]) -> None:
    for x in range(len(row)):
        sums[x] += sign * np.float64(row[x])


@njit(error_model="numpy")
def _add_moments(
    row: NDArray[np.float32], sign: float, first: NDArray[np.float64], second: NDArray[np.float64]
) -> None:
    for x in range(len(row)):
        value = np.float64(row[x])
        first[x] += sign * value
        second[x] += sign * value * value


@njit(error_model="numpy")
def _accumulate(
    first: NDArray[np.float64],
    second: NDArray[np.float64],
    radius: int,
    running_first: NDArray[np.float64],
    running_second: NDArray[np.float64],
) -> None:
    """Running sums, 0 before the row and the total after it, so that no window needs a look at the border.

    Four at a time: each step waits for one addition instead of four.
    """
    columns = len(first)
    running_first[: radius + 1] = 0.0
    running_second[: radius + 1] = 0.0
    total, total_second = 0.0, 0.0
    whole = columns // 4 * 4
    for x in range(0, whole, 4):
        at = x + radius + 1
        pair, pair_second = first[x] + first[x + 1], second[x] + second[x + 1]
        three, three_second = pair + first[x + 2], pair_second + second[x + 2]
        running_first[at] = total + first[x]
        running_second[at] = total_second + second[x]
        running_first[at + 1] = total + pair
        running_second[at + 1] = total_second + pair_second
        running_first[at + 2] = total + three
        running_second[at + 2] = total_second + three_second
        total += three + first[x + 3]
        total_second += three_second + second[x + 3]
        running_first[at + 3] = total
        running_second[at + 3] = total_second
    for x in range(whole, columns):
        total += first[x]
        total_second += second[x]
        running_first[x + radius + 1] = total
        running_second[x + radius + 1] = total_second
    running_first[columns + radius + 1 :] = total
    running_second[columns + radius + 1 :] = total_second


@njit(error_model="numpy")
def _mean(
    running: NDArray[np.float64],
    radius: int,
    shares: NDArray[np.float64],
    tall: float,
    out: NDArray[np.float32],
) -> None:
    ahead = running[2 * radius + 1 :]
    for x in range(len(out)):
        out[x] = np.float32((ahead[x] - running[x]) * (shares[x] * tall))


@njit(fastmath={"contract"}, error_model="numpy")
def _solve(
    running_first: NDArray[np.float64],
    running_second: NDArray[np.float64],
    radius: int,
    shares: NDArray[np.float64],
    tall: float,
    eps: np.float32,
    a: NDArray[np.float32],
    b: NDArray[np.float32],
) -> None:
    """a and b of a row of windows; (1 - a) as eps / (variance + eps), which does not cancel."""
    ahead_first, ahead_second = running_first[2 * radius + 1 :], running_second[2 * radius + 1 :]
    for x in range(len(a)):
        share = shares[x] * tall
        mean = (ahead_first[x] - running_first[x]) * share
        variance = np.float32((ahead_second[x] - running_second[x]) * share - mean * mean)
        # Rounding can leave a flat window's variance slightly negative.
        variance = variance if variance > np.float32(0.0) else np.float32(0.0)
        smooth = eps / (variance + eps)
        a[x] = np.float32(1.0) - smooth
        b[x] = smooth * np.float32(mean)
