"""Memory of a chunk."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from enhance.pixel_block import CHUNK, LINE, PLANES, zero_chunk


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
