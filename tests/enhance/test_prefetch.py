"""Any place can be asked for, and nothing changes by it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from enhance.prefetch import fetch, fetch_row


@njit(error_model="numpy")
def ask(pixels: NDArray[Any], y: int, x: int) -> None:
    fetch(pixels, y, x)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("shape", [(5, 301, 3), (5, 301)])
@pytest.mark.parametrize("place", [(0, 0), (3, 250), (4, 300), (1 << 30, 1 << 20), (-(1 << 30), 0)])
def test_what_does_not_exist_may_be_asked_for(
    kind: type[np.generic], shape: tuple[int, ...], place: tuple[int, int]
) -> None:
    pixels = np.arange(np.prod(shape)).reshape(shape).astype(kind)
    before = pixels.tobytes()
    ask(pixels, *place)
    assert pixels.tobytes() == before
    assert "llvm.prefetch" in "".join(ask.inspect_llvm().values())


@njit(error_model="numpy")
def ask_row(pixels: NDArray[Any], y: int) -> None:
    fetch_row(pixels, y)


@pytest.mark.parametrize("y", [-1, 0, 4, 5, 1 << 40])
def test_rows_that_do_not_exist_may_be_asked_for(y: int) -> None:
    pixels = np.arange(5 * 301, dtype=np.float32).reshape(5, 301)
    before = pixels.tobytes()
    ask_row(pixels, y)
    assert pixels.tobytes() == before
    assert "llvm.prefetch" in "".join(ask_row.inspect_llvm().values())
