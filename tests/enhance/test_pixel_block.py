"""Memory of a chunk."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

from enhance.pixel_block import CHUNK, LINE, PLANES, zero_chunk, zero_row


@njit
def _chunks(count: int) -> list[Any]:
    return [zero_chunk() for _ in range(count)]  # type: ignore[call-arg]


def test_every_chunk_begins_with_a_line_of_the_cache_and_has_memory_of_its_own() -> None:
    chunks = _chunks(20)
    assert {chunk.ctypes.data % LINE for chunk in chunks} == {0}
    for value, chunk in enumerate(chunks):
        assert (chunk.shape, chunk.dtype) == ((PLANES, CHUNK), np.float32)
        assert not chunk.any()
        chunk[:] = value + 1
    assert [set(chunk.ravel().tolist()) for chunk in chunks] == [{value + 1.0} for value in range(20)]


@njit
def _rows(count: int, like: Any) -> list[Any]:
    return [zero_row(3 * 16, like.dtype).reshape((3, 16)) for _ in range(count)]  # type: ignore[call-arg]


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_every_row_of_any_type_begins_with_a_line_of_the_cache(dtype: Any) -> None:
    rows = _rows(20, np.empty(0, dtype))
    assert {row.ctypes.data % LINE for row in rows} == {0}
    for value, row in enumerate(rows):
        assert (row.shape, row.dtype) == ((3, 16), dtype)
        assert not row.any()
        row[:] = value + 1
    assert [set(row.ravel().tolist()) for row in rows] == [{value + 1} for value in range(20)]
