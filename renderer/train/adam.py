"""Adam (Kingma & Ba 2015, Algorithm 1) that leaves parameters without gradient alone.

A row that no pixel saw, and a control value whose time is not near the frame's, keep their value and
their moments: that is most of the numbers of a dynamic model in any one step.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.stored_arrays import FIRST, SECOND, Arrays

BETA_1, BETA_2 = 0.9, 0.999
EPSILON = 1e-15


@dataclass(frozen=True, eq=False)
class Moments:
    """Running means of the gradients by arrays, and of their squares, by the arrays' names."""

    first: Arrays
    second: Arrays

    @classmethod
    def of(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Before the first step: 0."""
        return cls(*({name: np.zeros_like(value) for name, value in arrays.items()} for _ in range(2)))

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], names: Iterable[str]) -> Self:
        """Copies of what `arrays` gave, among others."""
        chosen = tuple(names)
        return cls(*({name: arrays[of + name].copy() for name in chosen} for of in (FIRST, SECOND)))

    def arrays(self) -> Arrays:
        """As a checkpoint has them."""
        first = {FIRST + name: value for name, value in self.first.items()}
        return first | {SECOND + name: value for name, value in self.second.items()}


def corrected_rate(rate: float, steps: int) -> float:
    """Rate with both bias corrections folded in, for the `steps`-th update (from 1)."""
    return float(rate * np.sqrt(1.0 - BETA_2**steps) / (1.0 - BETA_1**steps))


@njit(forceinline=True, error_model="numpy")
def adam_update(
    value: np.float32, gradient: np.float32, first: np.float32, second: np.float32, rate: np.float32
) -> tuple[np.float32, np.float32, np.float32]:
    first = np.float32(BETA_1) * first + np.float32(1.0 - BETA_1) * gradient
    second = np.float32(BETA_2) * second + np.float32(1.0 - BETA_2) * gradient * gradient
    return value - rate * first / (np.sqrt(second) + np.float32(EPSILON)), first, second


@njit(parallel=True, cache=True, error_model="numpy")
def update_rows(
    values: NDArray[np.float32],  # (N, C), updated
    gradients: NDArray[np.float32],  # (N, C)
    first: NDArray[np.float32],  # (N, C), updated
    second: NDArray[np.float32],  # (N, C), updated
    seen: NDArray[np.bool_],  # (N,)
    rate: float,
) -> None:
    step = np.float32(rate)
    for n in prange(values.shape[0]):
        if seen[n]:
            for c in range(values.shape[1]):
                values[n, c], first[n, c], second[n, c] = adam_update(
                    values[n, c], gradients[n, c], first[n, c], second[n, c], step
                )


@njit(parallel=True, cache=True, error_model="numpy")
def coast_taps(
    controls: NDArray[np.float32],  # (N, K, C), updated
    first: NDArray[np.float32],  # (K, N, C), updated
    second: NDArray[np.float32],  # (K, N, C), updated
    start: int,
    rates: NDArray[np.float32],  # (K,)
) -> None:
    """The published update, with gradient 0, of all control values but the four that start at `start`."""
    for n in prange(controls.shape[0]):
        for k in range(controls.shape[1]):
            if start <= k < start + 4:
                continue
            for c in range(controls.shape[2]):
                controls[n, k, c], first[k, n, c], second[k, n, c] = adam_update(
                    controls[n, k, c], np.float32(0.0), first[k, n, c], second[k, n, c], rates[k]
                )


@njit(parallel=True, cache=True, error_model="numpy")
def update_taps(
    controls: NDArray[np.float32],  # (N, K, C), updated
    gradients: NDArray[np.float32],  # (N, C), by the curves' values
    first: NDArray[np.float32],  # (K, N, C), updated
    second: NDArray[np.float32],  # (K, N, C), updated
    seen: NDArray[np.bool_],  # (N,)
    start: int,
    weights: NDArray[np.float32],  # (4,)
    rates: NDArray[np.float32],  # (4,), one a tap
    smoothing: float,
) -> None:
    """Update the four active control values of each curve, then pull them to their neighbours' mean."""
    last = controls.shape[1] - 1
    pull = np.float32(smoothing)
    for n in prange(controls.shape[0]):
        if not seen[n]:
            continue
        for c in range(controls.shape[2]):
            for tap in range(4):
                k = start + tap
                controls[n, k, c], first[k, n, c], second[k, n, c] = adam_update(
                    controls[n, k, c],
                    weights[tap] * gradients[n, c],
                    first[k, n, c],
                    second[k, n, c],
                    rates[tap],
                )
            for k in range(max(start, 1), min(start + 3, last - 1) + 1):
                middle = np.float32(0.5) * (controls[n, k - 1, c] + controls[n, k + 1, c])
                controls[n, k, c] += pull * (middle - controls[n, k, c])
