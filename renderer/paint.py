"""Splats in colours that show a quantity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from renderer.splats import Splats


def painted(splats: Splats, colors: NDArray[np.floating]) -> Splats:
    """In other colours (N, 3), the same from everywhere."""
    return replace(splats, colors=colors.astype(np.float32), harmonics=splats.harmonics[:, :0])


def by_motion(splats: Splats, first: Splats) -> Splats:
    """How far each has gone from where it was in `first`, in scene units, in all three channels."""
    way = np.linalg.norm(splats.means - first.means, axis=1)
    return painted(splats, np.repeat(way[:, None], 3, axis=1))
