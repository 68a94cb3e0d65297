"""Motion by curves of each Gaussian alone."""

from __future__ import annotations

import numpy as np

from renderer.deformation.spline_motion import SplineMotion
from renderer.splats import Float32Array


def without_nodes(positions: Float32Array, colors: Float32Array | None = None) -> SplineMotion:
    """Of control values (N, K, 3) of positions and, where given, of colours; opacities stay."""
    nothing = np.zeros((0, *positions.shape[1:]), np.float32)
    return SplineMotion(
        position_controls=positions,
        color_controls=nothing if colors is None else colors,
        opacity_controls=nothing[..., :1],
        node_controls=nothing,
        node_indices=np.zeros((0, 4), np.int32),
        node_weights=np.zeros((0, 4), np.float32),
    )
