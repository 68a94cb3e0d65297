"""A part of a kernel counts no references to the arrays that it is given."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enhance.part import part


def _sums(given: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    for y in range(len(given)):
        row = given[y]
        if len(row) > y:
            out[y] = row[y:].sum()


counted, uncounted = njit(error_model="numpy")(_sums), part()(_sums)


def code(kernel: Any) -> str:
    return "".join(kernel.inspect_llvm().values())


def test_no_references_are_counted_and_results_are_the_same() -> None:
    given = np.random.default_rng(0).random((5, 7), np.float32)
    results = np.zeros((2, 5), np.float32)
    counted(given, results[0])
    uncounted(given, results[1])
    np.testing.assert_array_equal(results[0], results[1])
    assert results[0].any()
    assert "call void @NRT_incref" in code(counted)
    assert "call void @NRT_incref" not in code(uncounted)
