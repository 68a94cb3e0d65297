"""Selected Gaussians in colour: a model to look at, not to keep."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from renderer.deformation.spline_motion import SplineMotion
from renderer.gaussians import DynamicGaussians

COLOR = (0.0, 0.78, 1.0)
"""No tissue is like it, nor what enhancement makes of tissue."""
OWN = np.float32(0.35)
"""Share of their own colour that is left, so that their shape can still be seen."""


def highlighted(model: DynamicGaussians, chosen: NDArray[np.bool_]) -> DynamicGaussians:
    """The same with `chosen` (N,) in one colour, at every time and from every side."""
    share = np.where(chosen, OWN, np.float32(1))
    raw, motion = model.raw, model.motion
    colors = share[:, None] * raw.colors + (1 - share)[:, None] * np.array(COLOR, np.float32)
    if isinstance(motion, SplineMotion) and len(motion.color_controls):
        motion = replace(motion, color_controls=share[:, None, None] * motion.color_controls)
    raw = replace(raw, colors=colors, harmonics=share[:, None, None] * raw.harmonics)
    return DynamicGaussians(raw, motion)
