"""The scale and shift by which a guessed map agrees with a known one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from renderer.clip import BoolImage

FloatImage = NDArray[np.float32] | NDArray[np.float64]

_HUBER = 1.345
"""Residual, in standard deviations, from which its weight falls: 95 % efficient for Gaussian noise."""
TO_DEVIATION = 1.4826
"""Standard deviation over median absolute deviation of a Gaussian."""
_ROUNDS = 50
_SETTLED = 1e-9


def aligned(prior: FloatImage, depth: FloatImage, mask: BoolImage) -> tuple[float, float]:
    """Scale and shift with which scale * prior + shift fits `depth` where `mask` is True.

    All are (H, W); `prior` and `depth` must be of one kind, for monocular maps inverse depth, since
    these are known up to scale and shift of it. Minimises Huber's loss (1964) by iteratively
    reweighted least squares; its threshold follows the median absolute residual, so that up to
    about a third of the pixels may disagree altogether. A prior that is constant under the mask has
    scale 0. Equivariant: aligned(a * prior + b, c * depth + d) undoes and does the same.

    Raises:
        ValueError: no pixel under the mask, or values that are not finite there.
    """
    guess, known = prior[mask].astype(np.float64), depth[mask].astype(np.float64)
    if not guess.size:
        raise ValueError("expected pixels under the mask, got none")
    if not (np.isfinite(guess).all() and np.isfinite(known).all()):
        raise ValueError("expected finite values under the mask, got NaN or infinity")
    weights = np.ones(guess.size)
    scale, shift = 0.0, 0.0
    for _ in range(_ROUNDS):
        before = scale, shift
        scale, shift = _weighted_line(guess, known, weights)
        residuals = np.abs(known - scale * guess - shift)
        threshold = _HUBER * TO_DEVIATION * float(np.median(residuals))
        moved = abs(scale - before[0]) * np.ptp(guess) + abs(shift - before[1])
        if threshold == 0 or moved <= _SETTLED * threshold:
            break
        weights = np.minimum(1, threshold / np.maximum(residuals, threshold))
    return scale, shift


def _weighted_line(
    x: NDArray[np.float64], y: NDArray[np.float64], weights: NDArray[np.float64]
) -> tuple[float, float]:
    """Slope and intercept of least squares, about the weighted means so that large offsets cost nothing."""
    total = weights.sum()
    middle_x, middle_y = float(weights @ x / total), float(weights @ y / total)
    away = x - middle_x
    spread = float(weights @ (away * away))
    slope = float(weights @ (away * (y - middle_y)) / spread) if np.ptp(x) > 0 and spread > 0 else 0.0
    return slope, middle_y - slope * middle_x
