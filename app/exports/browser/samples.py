"""A motion that is no spline, at as many even moments as it takes to go through its frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, sqrt
from typing import Final

import numpy as np

from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians

USUAL: Final = 48
"""Moments, where no more are needed."""
SPARE: Final = 1.1
"""Of the moments that the error asks for, as it need not fall with the square of their distance."""


@dataclass(frozen=True)
class Sampling:
    """How near to the model samples have to be, and how many there may be."""

    frames: int
    """At which that counts, the first at 0, all as far apart as the last is from 1."""
    tolerance: float
    """In scene units, of positions."""
    most: int
    """Moments; USUAL are always allowed."""


@dataclass(frozen=True, eq=False)
class Samples:
    """The Gaussians at even moments, the first at 0, the last at 1."""

    moments: tuple[RawGaussians, ...]
    error: float | None = None
    """Largest distance at a frame between a position of the model and the line between two samples, in scene
    units; None: not asked for."""


def sampled(model: DynamicGaussians, sampling: Sampling | None) -> Samples:
    """At USUAL moments, or at more where those are farther off than the tolerance; never more than a sample
    at each frame, which leaves no error there."""
    moments = _at(model, USUAL)
    if sampling is None:
        return Samples(moments)
    top = min(sampling.frames + 1, max(sampling.most, USUAL))
    while (error := _error(model, moments, sampling.frames)) > sampling.tolerance and len(moments) != top:
        # The error of lines between samples goes with the square of how far these are apart.
        wanted = len(moments) * SPARE * sqrt(error / max(sampling.tolerance, error / 100))
        moments = _at(model, min(ceil(wanted), top))
    return Samples(moments, error)


def _at(model: DynamicGaussians, count: int) -> tuple[RawGaussians, ...]:
    return tuple(model.motion.moved(model.raw, float(time)) for time in np.linspace(0, 1, count))


def _error(model: DynamicGaussians, moments: Sequence[RawGaussians], frames: int) -> float:
    """See Samples.error."""
    largest = 0.0
    for frame in range(frames):
        place = frame / frames * (len(moments) - 1)
        first = min(int(place), len(moments) - 2)
        before, after = moments[first].means, moments[first + 1].means
        shown = before + np.float32(place - first) * (after - before)
        true = model.motion.moved(model.raw, frame / frames).means
        largest = max(largest, float(np.linalg.norm(shown - true, axis=1).max(initial=0.0)))
    return largest
