"""Whether points move as those around them do: noise of tracks and of depth is each point's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from renderer.camera import FloatArray
from renderer.poses.bundle import summed
from renderer.poses.deforming import Deforming
from renderer.poses.outlying_points import nearest
from renderer.poses.rigid_share import rigid_part


def left_by_neighbours(now: Deforming) -> float:
    """What is left over in the image (median) where each point moves as the median of those around it, over
    what is left where all move as one rigid body. A point that a few frames show fits any motion; those
    beside it do not fit its errors."""
    rigid = rigid_part(now)
    own = now.shifts - rigid
    beside = np.median(own[nearest(now.rest.astype(np.float32))], axis=1)
    return _left(now, rigid + beside) / max(_left(now, rigid), 1e-12)


def _left(now: Deforming, shifts: FloatArray) -> float:
    """px in the median, where points are shifted so, and rest where that fits what was found best."""
    change = np.einsum("nk,nki->ni", now.courses[now.frames], (now.shifts - shifts)[now.points])
    count = np.bincount(now.points, minlength=len(now.rest))
    mean = summed(change, now.points, len(now.rest)) / np.maximum(count, 1)[:, None]
    there = replace(now, shifts=shifts, rest=now.rest + mean)
    return float(np.median(np.abs(there.apart()[:, :2])))
