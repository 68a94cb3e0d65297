from __future__ import annotations

import cv2
import numpy as np
import pytest

from enhance.pixel_block import CHUNK
from enhance.upscale import at_places, bring_up


@pytest.mark.parametrize("grid", [1, 2, 3, 4, 8])
@pytest.mark.parametrize("size", [(1, 1), (2, 5), (9, 70)])
def test_rows_are_those_of_the_whole_brought_up(size: tuple[int, int], grid: int) -> None:
    """Also one below the other, as they are asked for, at single places, and whatever was in their memory."""
    blocks = np.random.default_rng(grid).random(size).astype(np.float32)
    height, width = size[0] * grid, size[1] * grid
    whole = cv2.resize(blocks, (width, height), interpolation=cv2.INTER_LINEAR)
    lines, held = np.full((2, 1, width + CHUNK), np.nan, np.float32), np.full(2, -1)
    for y in range(height):
        weight = bring_up(blocks[None], y, grid, lines, held)
        row = lines[0, 0, :width] + weight * (lines[1, 0, :width] - lines[0, 0, :width])
        np.testing.assert_allclose(row, whole[y], atol=1e-5)
    rows, columns = np.arange(0, height, 2), np.arange(0, width, 3)
    np.testing.assert_allclose(at_places(blocks, rows, columns, grid), whole[::2, ::3], atol=1e-5)
