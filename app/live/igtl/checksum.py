"""The checksum of OpenIGTLink messages: CRC-64 with ECMA-182's polynomial, high bits first, from zero."""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

POLYNOMIAL: Final = np.uint64(0x42F0E1EBA9EA3693)
"""ECMA-182, without the bit of x^64."""
AT_ONCE: Final = 8
"""Bytes that one step takes, each by a table of its own."""

Table = NDArray[np.uint64]


def crc64(data: NDArray[np.uint8]) -> int:
    """Of the bytes (N,). Other threads go on meanwhile: of a frame it is some milliseconds."""
    return int(_crc64(data, TABLES))


@njit(nogil=True, cache=True)
def _tables(polynomial: np.uint64) -> Table:
    """(8, 256): what a byte comes to, and what it comes to with 1 to 7 zero bytes behind it."""
    tables = np.empty((AT_ONCE, 256), np.uint64)
    one, top = np.uint64(1), np.uint64(63)
    for byte in range(256):
        rest = np.uint64(byte) << np.uint64(56)
        for _ in range(8):
            rest = (rest << one) ^ (polynomial if rest >> top else np.uint64(0))
        tables[0, byte] = rest
    for behind in range(1, AT_ONCE):
        for byte in range(256):
            rest = tables[behind - 1, byte]
            tables[behind, byte] = (rest << np.uint64(8)) ^ tables[0, rest >> np.uint64(56)]
    return tables


@njit(nogil=True, cache=True)
def _crc64(data: NDArray[np.uint8], tables: Table) -> np.uint64:
    rest, low = np.uint64(0), np.uint64(255)
    whole = data.size // AT_ONCE * AT_ONCE
    for start in range(0, whole, AT_ONCE):
        step = np.uint64(0)
        for place in range(AT_ONCE):
            byte = np.uint64(data[start + place]) ^ ((rest >> np.uint64(56 - 8 * place)) & low)
            step ^= tables[AT_ONCE - 1 - place, byte]
        rest = step
    for place in range(whole, data.size):
        byte = (rest >> np.uint64(56)) ^ np.uint64(data[place])
        rest = (rest << np.uint64(8)) ^ tables[0, byte]
    return rest


TABLES: Final = _tables(POLYNOMIAL)
