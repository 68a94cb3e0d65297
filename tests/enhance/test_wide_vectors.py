"""A kernel that asks for wide vectors tells LLVM so, and gives the same bits."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enhance.wide_vectors import WIDE, wide_vectors


@njit(fastmath={"contract"}, error_model="numpy")
def plain(given: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    for i in range(len(given)):
        out[i] = given[i] / (given[i] * given[i] + np.float32(0.1))


@njit(fastmath={"contract"}, error_model="numpy")
def wide(given: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    wide_vectors()
    for i in range(len(given)):
        out[i] = given[i] / (given[i] * given[i] + np.float32(0.1))


def code(kernel: Any) -> str:
    return "".join(kernel.inspect_llvm().values())


def test_it_is_asked_for_and_changes_no_bit() -> None:
    given = np.random.default_rng(0).random(1003, np.float32)
    results = np.empty((2, len(given)), np.float32)
    plain(given, results[0])
    wide(given, results[1])
    assert results[0].tobytes() == results[1].tobytes()
    assert WIDE in code(wide)
    assert WIDE not in code(plain)
