"""Splats: what leaves training and is drawn. Numpy, activated values, one moment in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float32Array = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Splats:
    """N Gaussians in world space, C-contiguous float32, linear ("activated") values.

    means (N, 3); quats (N, 4) wxyz, any non-zero length; scales (N, 3) standard deviations > 0;
    opacities (N,) in [0, 1]; colors (N, 3) display-referred RGB, nominally [0, 1].

    Raises:
        ValueError: shapes that do not agree. The message names the field.
    """

    means: Float32Array
    quats: Float32Array
    scales: Float32Array
    opacities: Float32Array
    colors: Float32Array

    def __post_init__(self) -> None:
        count = len(self.means)
        shapes = {"means": (3,), "quats": (4,), "scales": (3,), "opacities": (), "colors": (3,)}
        for name, tail in shapes.items():
            value = np.ascontiguousarray(getattr(self, name), dtype=np.float32)
            if value.shape != (count, *tail):
                raise ValueError(f"Splats.{name} must have shape {(count, *tail)}, got {value.shape}")
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.means)
