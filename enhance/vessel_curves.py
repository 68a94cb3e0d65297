"""Curves of V that the second pass of `vessel` needs of every pixel, as polynomials: faster than powers.

Both are smooth where they are used; errors are in grey levels of the result, over all z and gamma.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from enhance.brightness import brighten
from enhance.exposure import exposed
from enhance.part import part
from enhance.pixel_block import ONE, THREE, TWO, ZERO

TERMS: Final = 11
NODES: Final = np.cos(np.pi * (np.arange(TERMS) + 0.5) / TERMS)
FROM_VALUES: Final = np.linalg.inv(np.vander(NODES))
LOWEST: Final = -8.0
"""log2 V of the first curve's left end; what is darker than a grey level is kept black anyhow."""
DIM: Final = 0.15
"""V at the left end of the second curve, below which neither `gamma` nor the density is applied."""
LIT: Final = 0.4
"""V from which on both are applied in full: dark vessels do not become black."""


@lru_cache(maxsize=4)
def brightness(z: float, exposure: float = 1.0) -> NDArray[np.float32]:
    """(TERMS,) of Vn (Eq 1), of V exposed so many times, by log2 V from LOWEST to 0; error below 0.02."""
    return _fitted(brighten(exposed(2.0 ** _places(LOWEST, 0.0), exposure), z))


@lru_cache(maxsize=4)
def powers(gamma: float) -> NDArray[np.float32]:
    """(TERMS,) of V^gamma by V, from DIM to 1; error below 0.002 levels."""
    return _fitted(_places(DIM, 1.0) ** gamma)


def _places(first: float, last: float) -> NDArray[np.float64]:
    """Chebyshev's points between two ends."""
    return first + (NODES + 1) * ((last - first) / 2)


def _fitted(values: NDArray[np.float64]) -> NDArray[np.float32]:
    """Coefficients, the highest first, of the polynomial through the values at NODES."""
    return np.asarray(FROM_VALUES @ values, np.float32)


@part(forceinline=True, fastmath={"contract"})
def value_of(terms: tuple[np.float32, ...], place: np.float32) -> np.float32:
    """Of a polynomial, by Horner's scheme."""
    a, b, c, d, e, f, g, h, i, j, k = terms
    high = ((((a * place + b) * place + c) * place + d) * place + e) * place + f
    return ((((high * place + g) * place + h) * place + i) * place + j) * place + k


@part(forceinline=True, fastmath={"contract"})
def unpacked(terms: NDArray[np.float32]) -> tuple[np.float32, ...]:
    """As a tuple, which loops keep in registers."""
    low = terms[5], terms[6], terms[7], terms[8], terms[9], terms[10]
    return terms[0], terms[1], terms[2], terms[3], terms[4], *low


@part(forceinline=True, fastmath={"contract"})
def faded(value: np.float32) -> np.float32:
    """Smoothstep of V between DIM and LIT."""
    t = (value - np.float32(DIM)) * np.float32(1 / (LIT - DIM))
    t = t if t > ZERO else ZERO
    t = t if t < ONE else ONE
    return t * t * (THREE - TWO * t)
