"""How far a mesh is from the depth that a frame measured."""

from __future__ import annotations

from typing import Final

import numpy as np

from renderer.camera import FloatArray
from renderer.clip import Frame
from renderer.surface.maps import read
from renderer.surface.mesh import Mesh

MEASURED: Final = 0.999
"""Share of the depth between pixels that is measured."""


def depth_distances(mesh: Mesh, frame: Frame) -> FloatArray:
    """(N,) distances of those vertices that the frame's camera sees where it measured depth, along their own
    normals, in the clip's unit. On the phantom that is the distance to the true surface."""
    if frame.measured_depth is None:
        return np.zeros(0)
    points = mesh.vertices.astype(np.float64)
    pixels, depths = frame.camera.project(points)
    width, height = frame.camera.width, frame.camera.height
    inside = (pixels > 0.5).all(axis=1) & (pixels < np.array([width, height]) - 0.5).all(axis=1)
    measured = read(frame.depth_mask.astype(np.float32), pixels) > MEASURED
    known = inside & measured & (depths > 0)
    ray = (points - frame.camera.position) / np.where(known, depths, 1)[:, None]
    off = read(frame.measured_depth, pixels) - depths
    return np.asarray(np.abs(off * (ray * mesh.normals.astype(np.float64)).sum(axis=1))[known])
