"""Flexible deformation modelling of Deform3DGS (Yang et al., MICCAI 2024, section 2.2): bumps in time.

Each of the C = 10 channels of a Gaussian (3 position, 4 quaternion, 3 log-scale) is moved by

    sum over B functions of w exp(-u^2),  u = (t - m)^2 / (s^2 + 1e-4)

with a learnable weight w, centre m and width s. The exponent is of fourth order in t, as in the published
code: flat-topped bumps that end more sharply than the Gaussians of the paper's text.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.rasterize.exp2 import exp2
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Float32Array
from renderer.stored_arrays import Arrays, Stored, check

CHANNELS = 10
POSITION, QUATERNION, SCALE = slice(0, 3), slice(3, 7), slice(7, 10)
WEIGHT, CENTRE, WIDTH = range(3)
FLOOR = np.float32(1e-4)
"""Added to the squared widths."""
MAX_U = np.float32(4.0)
"""Beyond, a bump is below exp(-16) = 1.1e-7 of its weight, less than a float32 tells from 0 beside it."""
LOG2_E = np.float32(np.log2(np.e))
FAINTEST = np.float32(-60.0)
"""Power of two at which a bump ends: fainter ones would make denormal numbers, which are slow."""
FIRST, LAST = range(2)
TASK = 64
"""Gaussians that one thread takes at a time."""


@dataclass(frozen=True, eq=False)
class FlexibleMotion:
    """B bumps for each channel of each Gaussian."""

    NAMES: ClassVar[tuple[str, ...]] = ("bumps",)

    bumps: Float32Array
    """(B, N, 3, C) weights, centres and widths; centres and widths in clip time, weights of positions in the
    clip's unit, those of quaternions and log-scales as these raw values are. Function by function, so that
    those that count at one time lie together."""
    spans: Float32Array = field(init=False)
    """(B, N, 2) first and last time at which any channel of a function counts: elsewhere it is not read."""

    def __post_init__(self) -> None:
        spans = np.empty((*self.bumps.shape[:2], 2), np.float32)
        measure_spans(self.bumps, spans)
        object.__setattr__(self, "spans", spans)

    @classmethod
    def at_rest(cls, count: int, functions: int, width: float) -> Self:
        """No motion: weights 0, centres evenly from 0 to 1, all of one width."""
        bumps = np.zeros((functions, count, 3, CHANNELS), np.float32)
        bumps[:, :, CENTRE] = np.linspace(0, 1, functions, dtype=np.float32)[:, None, None]
        bumps[:, :, WIDTH] = width
        return cls(bumps)

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        """See Motion."""
        if self.bumps.shape[1] != len(raw):
            raise ValueError(f"expected a motion of {len(raw)} Gaussians, got one of {self.bumps.shape[1]}")
        moves = np.zeros((len(raw), CHANNELS), np.float32)
        add_bumps(self.bumps, self.spans, time, moves)
        return replace(
            raw,
            means=raw.means + moves[:, POSITION],
            quats=raw.quats + moves[:, QUATERNION],
            log_scales=raw.log_scales + moves[:, SCALE],
        )

    def rows(self, index: NDArray[np.int64]) -> Self:
        """See Motion."""
        return type(self)(self.bumps[:, index])

    def arrays(self) -> Arrays:
        """See Motion."""
        return {"bumps": self.bumps}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """See Motion."""
        return cls(arrays["bumps"])

    @classmethod
    def check(cls, arrays: Mapping[str, NDArray[Any]], count: int) -> None:
        """See Motion."""
        check(arrays, {"bumps": Stored(f"F N 3 {CHANNELS}")}, {"N": count})


@njit(parallel=True, cache=True, error_model="numpy")
def add_bumps(
    bumps: NDArray[np.float32],  # (B, N, 3, C)
    spans: NDArray[np.float32],  # (B, N, 2)
    time: float,
    out: NDArray[np.float32],  # (N, C), added to
) -> None:
    """Add every channel's value at `time`."""
    now, count = np.float32(time), bumps.shape[1]
    for task in prange((count + TASK - 1) // TASK):
        for j in range(len(bumps)):
            for n in range(task * TASK, min(task * TASK + TASK, count)):
                if not spans[j, n, FIRST] <= now <= spans[j, n, LAST]:
                    continue
                for c in range(CHANNELS):
                    away, width = now - bumps[j, n, CENTRE, c], bumps[j, n, WIDTH, c]
                    u = away * away / (width * width + FLOOR)
                    out[n, c] += bumps[j, n, WEIGHT, c] * exp2(max(-LOG2_E * u * u, FAINTEST))


@njit(forceinline=True, error_model="numpy")
def measure_span(bumps: NDArray[np.float32], spans: NDArray[np.float32], j: int, n: int) -> None:
    """Of one function of one Gaussian: where u <= MAX_U in any channel."""
    first, last = np.float32(np.inf), np.float32(-np.inf)
    for c in range(CHANNELS):
        width = bumps[j, n, WIDTH, c]
        reach = np.sqrt(MAX_U * (width * width + FLOOR))
        first = min(first, bumps[j, n, CENTRE, c] - reach)
        last = max(last, bumps[j, n, CENTRE, c] + reach)
    spans[j, n, FIRST], spans[j, n, LAST] = first, last


@njit(parallel=True, cache=True, error_model="numpy")
def measure_spans(
    bumps: NDArray[np.float32],  # (B, N, 3, C)
    spans: NDArray[np.float32],  # (B, N, 2), out
) -> None:
    """Of all functions."""
    for j in range(len(bumps)):
        for n in prange(bumps.shape[1]):
            measure_span(bumps, spans, j, n)
