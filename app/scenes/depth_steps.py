"""Depth as whole numbers of 16 bits, in steps that are the same for all frames of a scene."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from renderer.splats import Float32Array

MOST: Final = 65535
ROOM: Final = 4
"""Times the distance to the tissue, up to which depth is told."""


def step_of(distance: float) -> float:
    """The least power of ten by which `ROOM` times the distance can be told, in scene units."""
    return float(10.0 ** math.ceil(math.log10(ROOM * distance / MOST)))


def in_steps(depth: Float32Array, step: float) -> NDArray[np.uint16]:
    """(H, W) rounded; what is farther away than the numbers reach has the last of them."""
    return np.asarray(np.rint(np.clip(depth / step, 0, MOST)), np.uint16)
