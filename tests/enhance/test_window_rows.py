"""Running sums along a row of windows."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from enhance.window_rows import accumulate


@njit
def _accumulated(rows: NDArray[np.float64], whole: int) -> NDArray[np.float64]:
    running = np.full((2, rows.shape[1] + 2 * whole + 3), np.nan)
    accumulate(rows[0], rows[1], whole, running)
    return running


def _one_by_one(row: NDArray[np.float64]) -> list[float]:
    """In the order in which all versions add them up, so that results stay as they are bit by bit."""
    out, total = [], 0.0
    for x in range(0, len(row) // 4 * 4, 4):
        a, b, c, d = row[x : x + 4].tolist()
        out += [total + a, total + (a + b), total + ((a + b) + c), total + ((a + b) + (c + d))]
        total = out[-1]
    for one in row[len(out) :].tolist():
        out.append(total := total + one)
    return out


@pytest.mark.parametrize("columns", [1, 2, 3, 4, 5, 7, 8, 11, 64, 333])
@pytest.mark.parametrize("whole", [0, 1, 3, 15])
def test_running_sums_are_those_added_up_one_by_one(columns: int, whole: int) -> None:
    rows = np.random.default_rng(columns).random((2, columns)) * 100
    got = _accumulated(rows, whole)  # type: ignore[call-arg]
    for row, running in zip(rows, got, strict=True):
        before, within, after = np.split(running, [whole + 2, whole + 2 + columns])
        assert not before.any()
        assert within.tolist() == _one_by_one(row)
        assert after.tolist() == [within[-1]] * (whole + 1)
        np.testing.assert_allclose(within, np.cumsum(row), rtol=1e-13)
