"""Uniform cubic B-spline over the clip: K shared control values, four of them active at any time."""

from __future__ import annotations

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

MIN_CONTROLS = 4
FRAMES_PER_CONTROL, FEWEST_PER_CONTROL = 3.7, 2.3
"""Frames of a clip for each control value: as long as nobody looked, and where tissue moves fastest."""
MOST_CONTROLS = 120
"""Where there are more than by FRAMES_PER_CONTROL: a window of 400 frames is trained in 2 GB."""


def spline_taps(time: float, n_controls: int) -> tuple[int, NDArray[np.float32]]:
    """First active control value and the four weights at `time`, clipped to [0, 1].

    The K control values make K - 3 equal segments; the weights are non-negative and sum to 1, so a
    constant is reproduced exactly and there are no gaps between supports.

    Raises:
        ValueError: fewer than four control values.
    """
    if n_controls < MIN_CONTROLS:
        raise ValueError(
            f"expected at least {MIN_CONTROLS} control values for a cubic spline, got {n_controls}"
        )
    segments = n_controls - 3
    position = min(max(time, 0.0), 1.0) * segments
    first = min(int(position), segments - 1)
    u = position - first
    weights = np.array([(1 - u) ** 3, 3 * u**3 - 6 * u**2 + 4, -3 * u**3 + 3 * u**2 + 3 * u + 1, u**3])
    return first, (weights / 6.0).astype(np.float32)


def controls_for(n_frames: int, per_control: float = FRAMES_PER_CONTROL) -> int:
    """Number of control values for a clip."""
    return max(MIN_CONTROLS, round(n_frames / per_control))


def most_controls(n_frames: int) -> int:
    """Of a clip whose tissue moves fast."""
    return max(controls_for(n_frames), min(controls_for(n_frames, FEWEST_PER_CONTROL), MOST_CONTROLS))


@njit(parallel=True, cache=True)
def add_curve(
    controls: NDArray[np.float32],  # (N, K, C)
    first: int,
    weights: NDArray[np.float32],  # (4,)
    out: NDArray[np.float32],  # (N, C), added to
) -> None:
    """Add the value of each row's curve at the time of the taps."""
    for n in prange(controls.shape[0]):
        for c in range(controls.shape[2]):
            value = np.float32(0.0)
            for tap in range(4):
                value += weights[tap] * controls[n, first + tap, c]
            out[n, c] += value
