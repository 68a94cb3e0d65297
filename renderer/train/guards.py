"""What keeps a run from going wrong in silence: gradients that are no numbers, scales that run away."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.raw_gaussians import RawGaussians

LARGEST, SMALLEST = 1.0, 1e-7
"""Standard deviations of Gaussians in scene sizes; beyond, they are held there."""
JUDGED = 100
"""Steps before a loss is judged."""
SHARE = 0.02
"""Of the newest loss in the running mean."""
WORSE = 2.0
"""A running mean this many times the first loss is no training."""
TYPICAL = 0.5
"""Frames with this much of the tissue of the fullest one tell how the loss is."""


@dataclass
class Trouble:
    """Counts over a run."""

    not_finite: int = 0
    """Gradients of a Gaussian in one step that were left out."""
    held: int = 0
    """Scales held at their bounds."""

    @property
    def state(self) -> NDArray[np.int64]:
        """(2,) both counts; a checkpoint keeps them."""
        return np.array([self.not_finite, self.held], np.int64)

    def restore(self, state: NDArray[np.int64]) -> None:
        """Take over what `state` gave."""
        self.not_finite, self.held = map(int, state)

    def notices(self) -> Iterable[str]:
        """A sentence for each kind."""
        if self.not_finite:
            yield f"{self.not_finite} gradients were not finite, or too large to square, and were left out"
        if self.held:
            yield f"{self.held} times the size of a Gaussian diverged and was clamped"


def leave_out_broken(by: RawGaussians, seen: NDArray[np.bool_]) -> int:
    """Unmark the Gaussians with a gradient that is not finite, nor its square; how many there were. Their
    gradients become 0, as nodes gather those of all Gaussians."""
    lost = np.zeros(len(seen), bool)
    _find_broken(by.means, by.quats, by.log_scales, by.opacity_logits, by.colors, seen, lost)
    return int(np.count_nonzero(lost))


def hold_scales(log_scales: NDArray[np.float32], size: float) -> int:
    """Keep standard deviations within bounds, in place; how many numbers were beyond."""
    low, high = np.float32(np.log(SMALLEST * size)), np.float32(np.log(LARGEST * size))
    beyond = int(np.count_nonzero((log_scales < low) | (log_scales > high)))
    if beyond:
        np.clip(log_scales, low, high, out=log_scales)
    return beyond


def shorten(log_scales: NDArray[np.float32], most: float) -> None:
    """Hold the largest standard deviation of each Gaussian (N, 3) at `most` times the middle one, in place: a
    longer one is a needle, of which most pixels that it lies in say nothing."""
    a, b, c = log_scales.T
    middle = np.maximum(np.minimum(a, b), np.minimum(np.maximum(a, b), c))
    np.minimum(log_scales, (middle + np.float32(np.log(most)))[:, None], out=log_scales)


@njit(parallel=True, cache=True, error_model="numpy")
def _find_broken(
    by_means: NDArray[np.float32],
    by_quats: NDArray[np.float32],
    by_log_scales: NDArray[np.float32],
    by_logits: NDArray[np.float32],
    by_colors: NDArray[np.float32],
    seen: NDArray[np.bool_],  # (N,), unmarked where broken, gradients 0
    lost: NDArray[np.bool_],  # (N,), out
) -> None:
    for n in prange(len(seen)):
        if not seen[n]:
            continue
        total = by_logits[n] * by_logits[n]
        for c in range(3):
            total += by_means[n, c] * by_means[n, c] + by_log_scales[n, c] * by_log_scales[n, c]
            total += by_colors[n, c] * by_colors[n, c]
        for c in range(4):
            total += by_quats[n, c] * by_quats[n, c]
        # Not finite with a NaN or an infinity in it, or where Adam's second moment would overflow.
        if not np.isfinite(total):
            seen[n] = False
            by_means[n] = by_quats[n] = by_log_scales[n] = by_colors[n] = np.float32(0.0)
            by_logits[n] = np.float32(0.0)
            lost[n] = True


class LossWatch:
    """Tells a run that diverges from one that trains."""

    def __init__(self, state: NDArray[np.float64] | None = None) -> None:
        self.state = np.zeros(3) if state is None else state.copy()
        """Steps, loss of the first one, running mean; a checkpoint keeps them."""

    def add(self, loss: float, tissue: float = 1.0) -> None:
        """Of one step, on a frame with `tissue` as a share of the fullest one's.

        A frame with little tissue tells little: with none its loss is 0, and any other is a rise.
        """
        if tissue < TYPICAL:
            return
        steps, first, recent = self.state
        if steps == 0:
            first = recent = loss
        recent += SHARE * (loss - recent)
        self.state[:] = steps + 1, first, recent

    @property
    def problem(self) -> str | None:
        """One line, once the loss has risen for good."""
        steps, first, recent = self.state
        if not np.isfinite(recent):
            return "the loss is not finite"
        if steps >= JUDGED and recent > WORSE * first:
            return f"the loss rises: {first:.4g} at first, {recent:.4g} now"
        return None
