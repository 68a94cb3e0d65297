"""Rows times a matrix: right, and the same bytes wherever a row lies."""

from __future__ import annotations

import numpy as np
import pytest

from renderer.deformation.row_products import TOGETHER, row_products


@pytest.mark.parametrize("depth", [1, 3, 32, 65])
@pytest.mark.parametrize("width", [1, 10, 16, 33, 96])
def test_products_are_right_wherever_a_row_lies(depth: int, width: int) -> None:
    rng = np.random.default_rng(depth * width)
    rows = rng.normal(size=(16 * TOGETHER, depth)).astype(np.float32)
    matrix = rng.normal(size=(depth, width)).astype(np.float32)
    products = row_products(rows, matrix)
    assert products.shape == (len(rows), width)
    assert products.flags.c_contiguous
    magnitude = np.abs(rows.astype(np.float64)) @ np.abs(matrix.astype(np.float64))
    error = np.abs(products - rows.astype(np.float64) @ matrix.astype(np.float64))
    assert (error <= depth * np.finfo(np.float32).eps * magnitude).all()
    moved = rng.permutation(len(rows))
    np.testing.assert_array_equal(row_products(rows[moved], matrix), products[moved])
    np.testing.assert_array_equal(row_products(rows[TOGETHER:], matrix), products[TOGETHER:])
