"""Selected Gaussians in colour: a model to look at, not to keep."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from renderer.deformation.motion import Motion
from renderer.deformation.spline_motion import SplineMotion
from renderer.deformation.windowed_motion import LazyMotions, WindowedMotion
from renderer.gaussians import DynamicGaussians
from renderer.splats import Float32Array

COLOR = (0.0, 0.78, 1.0)
"""No tissue is like it, nor what enhancement makes of tissue."""
OWN = np.float32(0.35)
"""Share of their own colour that is left, so that their shape can still be seen."""


def highlighted(model: DynamicGaussians, chosen: NDArray[np.bool_]) -> DynamicGaussians:
    """The same with `chosen` (N,) in one colour, at every time and from every side."""
    raw, rows = model.raw, np.flatnonzero(chosen)
    colors, harmonics = raw.colors.copy(), raw.harmonics.copy()
    colors[rows] = OWN * colors.take(rows, axis=0) + (1 - OWN) * np.array(COLOR, np.float32)
    harmonics[rows] *= OWN
    raw = replace(raw, colors=colors, harmonics=harmonics)
    return DynamicGaussians(raw, _fainter(model.motion, np.where(chosen, OWN, np.float32(1))))


def _fainter(motion: Motion, share: Float32Array) -> Motion:
    """With so much of what colours do over time, of each Gaussian."""
    if isinstance(motion, SplineMotion) and len(motion.color_controls):
        return replace(motion, color_controls=share[:, None, None] * motion.color_controls)
    if isinstance(motion, WindowedMotion):
        parts = np.split(share, motion.first_rows[1:-1])
        read = LazyMotions(len(motion), lambda window: _fainter(motion.motions[window], parts[window]))
        return replace(motion, motions=read)
    return motion
