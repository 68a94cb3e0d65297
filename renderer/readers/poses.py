"""Poses as clip files write them."""

from __future__ import annotations

import numpy as np

from renderer.camera import FloatArray
from renderer.rotations import matrix


def pose_matrix(position: FloatArray, xyzw: FloatArray) -> FloatArray:
    """The (4, 4) matrix of a position (3,) and a quaternion (4,) of any length above 0.

    Raises:
        ValueError: the quaternion is 0, or a number is not finite.
    """
    length = float(np.linalg.norm(xyzw))
    if not (0 < length < np.inf and np.isfinite(position).all()):
        given = f"{np.ravel(position).tolist()} and {np.ravel(xyzw).tolist()}"
        raise ValueError(f"expected a finite position and a quaternion other than 0, got {given}")
    pose = np.eye(4)
    pose[:3, 3] = position
    pose[:3, :3] = matrix(np.roll(xyzw / length, 1))
    return pose
