"""How many pixels splats would cover if nothing lay in front of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from renderer.projection import (
    ACROSS,
    ALPHA_CUT,
    CENTER_X,
    CENTER_Y,
    DOWN,
    LOG2_E,
    LOG2_OPACITY,
    SHEAR,
)

NORMAL = 1.702
"""Slope of the logistic function that is the normal distribution's to 0.01."""


def footprints(records: NDArray[np.float32], width: int, height: int) -> NDArray[np.float64]:
    """(N,) sum of alpha, in pixels, within an image of that size, of visible splats of these records.

    Over the plane it is 2 pi sqrt(det C) (opacity - ALPHA_CUT); the share of it that lies in the image is
    taken along x and y apart, which at a corner of the image errs for slanted ones.
    """
    wide = records.astype(np.float64)
    yy = -0.5 * LOG2_E / wide[:, DOWN]
    determinant = -0.5 * LOG2_E * yy / wide[:, ACROSS]
    xx = determinant / yy + wide[:, SHEAR] ** 2 * yy
    area = 2 * np.pi * np.sqrt(determinant) * np.maximum(2.0 ** wide[:, LOG2_OPACITY] - ALPHA_CUT, 0)
    across = _inside(wide[:, CENTER_X], np.sqrt(xx), width)
    down = _inside(wide[:, CENTER_Y], np.sqrt(yy), height)
    return np.asarray(area * across * down)


def _inside(center: NDArray[np.float64], deviation: NDArray[np.float64], length: int) -> NDArray[np.float64]:
    """Share of normal distributions that lies between 0 and `length`."""
    ends = (np.array([[length], [0]]) - center) / deviation
    upper, lower = 0.5 + 0.5 * np.tanh(0.5 * NORMAL * ends)
    return np.asarray(upper - lower)
