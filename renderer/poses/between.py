"""The pose of a frame between two that have one."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from renderer.camera import FloatArray
from renderer.poses.rigid_motion import inverse
from renderer.rotations import conjugate, exponential, logarithm, matrix, product, quaternion


def between(poses: Mapping[int, FloatArray], at: int) -> FloatArray:
    """(4, 4) camera from world of frame `at`, turned and moved evenly between those before and after it."""
    before, after = max(each for each in poses if each < at), min(each for each in poses if each > at)
    share = (at - before) / (after - before)
    start, end = (inverse(poses[each]) for each in (before, after))
    turns = [quaternion(each[:3, :3]) for each in (start, end)]
    turn = product(turns[0], exponential(share * logarithm(product(conjugate(turns[0]), turns[1]))))
    found = np.eye(4)
    found[:3, :3] = matrix(turn)
    found[:3, 3] = (1 - share) * start[:3, 3] + share * end[:3, 3]
    return inverse(found)
