"""Rows times a matrix, where each row's result depends on that row alone.

Matrix libraries handle the rows at the edge of their tiles by other code than those within: a row that moves
to another place, as when Gaussians before it are deleted, then changes in its last bits.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange

from renderer.splats import Float32Array
from renderer.stack_arrays import stack_array

TOGETHER = 4
"""Rows that share what is loaded of the matrix."""
LANES = 16
"""Columns of a vector."""


def row_products(rows: Float32Array, matrix: Float32Array) -> Float32Array:
    """(P, N) of rows (P, K), P a multiple of TOGETHER, and a matrix (K, N).

    Of float32; in float64, by which the mathematics is checked, numpy's product serves.
    """
    if rows.dtype != np.float32:
        return rows @ matrix
    height, width = matrix.shape
    blocks = -(-width // LANES)
    padded = np.zeros((height, blocks * LANES), np.float32)
    padded[:, :width] = matrix
    vectors = np.ascontiguousarray(padded.reshape(height, blocks, LANES).transpose(1, 0, 2))
    products = np.empty((len(rows), blocks, LANES), np.float32)
    _multiply(np.ascontiguousarray(rows), vectors, products)
    return np.ascontiguousarray(products.reshape(len(rows), blocks * LANES)[:, :width])


@njit(parallel=True, cache=True, error_model="numpy", fastmath={"contract"})
def _multiply(rows: Float32Array, vectors: Float32Array, products: Float32Array) -> None:
    for group in prange(len(rows) // TOGETHER):
        for block in range(len(vectors)):
            _block(rows, vectors[block], products, group * TOGETHER, block)


@njit(cache=True, error_model="numpy", fastmath={"contract"})
def _block(rows: Float32Array, vectors: Float32Array, products: Float32Array, first: int, block: int) -> None:
    """TOGETHER rows and LANES columns; the sums stay in registers."""
    sums_0, sums_1 = stack_array(LANES), stack_array(LANES)
    sums_2, sums_3 = stack_array(LANES), stack_array(LANES)
    for lane in range(LANES):
        sums_0[lane] = sums_1[lane] = sums_2[lane] = sums_3[lane] = np.float32(0)
    for k in range(len(vectors)):
        a, b, c, d = rows[first, k], rows[first + 1, k], rows[first + 2, k], rows[first + 3, k]
        for lane in range(LANES):
            factor = vectors[k, lane]
            sums_0[lane] += a * factor
            sums_1[lane] += b * factor
            sums_2[lane] += c * factor
            sums_3[lane] += d * factor
    for lane in range(LANES):
        products[first, block, lane] = sums_0[lane]
        products[first + 1, block, lane] = sums_1[lane]
        products[first + 2, block, lane] = sums_2[lane]
        products[first + 3, block, lane] = sums_3[lane]
