"""Points far before or behind what is seen around them: of wrong tracks, and of what floats before tissue."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.camera import BoolArray, Camera, FloatArray
from renderer.evenly import evenly
from renderer.poses.rigid_motion import local, projected

_AROUND = 8
"""Points that one is compared with."""
_FARTHEST = 1.0
"""Of the logarithm of the depth, from the median around. By held-out training frames (400 steps, two seeds):
0.8 dB on a fetoscopy whose fluid is full of particles, nothing lost on a sinus; 0.5 gains less."""
_LOOKED_AT = 9
"""Views, evenly spread."""


def outlying(lens: Camera, poses: FloatArray, points: FloatArray) -> BoolArray:
    """(P,) whether points (P, 3) lie far before or behind those around them in half of the views that show
    them, at poses (K, 4, 4)."""
    looked_at = evenly(range(len(poses)), _LOOKED_AT)
    shown, far = np.zeros(len(points)), np.zeros(len(points))
    for place in looked_at:
        seen = local(poses[place], points)
        column, row = projected(lens, seen)[:, :2].T
        inside = (column > 0) & (column < lens.width) & (row > 0) & (row < lens.height) & (seen[:, 2] > 0)
        visible = np.flatnonzero(inside)
        if len(visible) <= _AROUND:
            continue
        depth = np.log(seen[visible, 2])
        beside = nearest(np.stack([column, row], axis=1)[visible].astype(np.float32))
        shown[visible] += 1
        far[visible] += np.abs(depth - np.median(depth[beside], axis=1)) > _FARTHEST
    return np.asarray((shown > 0) & (far >= shown / 2))


def nearest(places: NDArray[np.float32]) -> NDArray[np.int64]:
    """(V, _AROUND) the nearest others of (V, D)."""
    found = cv2.BFMatcher(cv2.NORM_L2).knnMatch(places, places, k=_AROUND + 1)
    return np.array([[each.trainIdx for each in row[1:]] for row in found])
