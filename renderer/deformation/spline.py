"""Uniform cubic B-spline over the clip: K shared control values, four of them active at any time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

MIN_CONTROLS = 4


def spline_taps(time: float, n_controls: int) -> tuple[int, NDArray[np.float32]]:
    """First active control value and the four weights at `time`, clipped to [0, 1].

    The K control values make K - 3 equal segments; the weights are non-negative and sum to 1, so a
    constant is reproduced exactly and there are no gaps between supports.

    Raises:
        ValueError: fewer than four control values.
    """
    if n_controls < MIN_CONTROLS:
        raise ValueError(f"a cubic spline needs at least {MIN_CONTROLS} control values, got {n_controls}")
    segments = n_controls - 3
    position = min(max(time, 0.0), 1.0) * segments
    first = min(int(position), segments - 1)
    u = position - first
    weights = np.array(
        [(1 - u) ** 3, 3 * u**3 - 6 * u**2 + 4, -3 * u**3 + 3 * u**2 + 3 * u + 1, u**3], dtype=np.float64
    )
    return first, (weights / 6.0).astype(np.float32)


def controls_for(n_frames: int) -> int:
    """Number of control values for a clip: one per 3.7 frames, as 17 for 63 (feasibility study)."""
    return max(MIN_CONTROLS, round(n_frames / 3.7))
