"""Values so far from most others that a range which holds all is coarse for these."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from renderer.splats import Float32Array

MOST: Final = (0.05, 0.95)
"""Shares of the values of a channel, below and above which few lie."""
FAR: Final = 10
"""Times what most span, beyond which a value is a stray."""


def usual_span(values: NDArray[np.floating[Any]]) -> float:
    """What most of (N, C) values span in the channel in which that is most."""
    if not len(values):
        return 0.0
    low, high = np.quantile(values, MOST, axis=0)
    return float((high - low).max(initial=0))


def bounds_without_strays(values: Float32Array) -> tuple[Float32Array, Float32Array]:
    """The least and the largest (C,) of (N, C) values, with strays moved in; where most are the same, none is
    one. Raises ValueError: no values."""
    low, high = values.min(axis=0), values.max(axis=0)
    reach = FAR * usual_span(values)
    if reach > 0:
        ends = np.quantile(values, MOST, axis=0)
        low = np.maximum(low, ends[0] - reach).astype(np.float32)
        high = np.minimum(high, ends[1] + reach).astype(np.float32)
    return low, high


def strays(values: Float32Array) -> NDArray[np.bool_]:
    """(N,) of (N, C): any channel is one."""
    if not len(values):
        return np.zeros(0, np.bool_)
    low, high = bounds_without_strays(values)
    return np.asarray(((values < low) | (values > high)).any(axis=1))
