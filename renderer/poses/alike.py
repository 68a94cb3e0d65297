"""Whether points move as those around them do: noise of tracks and of depth is each point's own."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from renderer.camera import FloatArray
from renderer.poses.bundle import summed
from renderer.poses.deforming import Deforming
from renderer.poses.outlying_points import nearest
from renderer.poses.rigid_share import by_speed, rigid_part

_HALF: Final = 0.5**0.5
"""Of a deviation. Where neighbours share less, noise of the motion is more than there is of it to gain. Of
phantoms that breathe and are pulled, the second motion leaves 0.23 to 0.58 in the image, of those that are
pulled alone 0.81 to 0.93; of pulls at two places that are as far 0.54 to 0.61, half as far 0.65 and 0.71, and
a quarter as far, where one motion leaves less error of the path (0.52 %) than two (0.95 %), 0.79. In depth
that is exact it leaves 0.25 to 0.29 as each point makes it, in depth that is off by 0.3 px all."""


def left_by_neighbours(now: Deforming) -> float:
    """What is left over in the image (median) where each point moves as the median of those around it, over
    what is left where all move as one rigid body. A point that a few frames show fits any motion; those
    beside it do not fit its errors."""
    rigid = rigid_part(now)
    return float(_left(now, rigid + _beside(now, rigid))[0] / _left(now, rigid)[0])


def shared_motions(now: Deforming) -> Deforming:
    """Of motions in order of their size (`by_size`), the first ones, that points share with those around
    them. Where there are fewer than were fitted, the others are how tracks drift, each for itself, and take
    the path along.

    A motion is shared where half of the variance that is left over without it in the image is gone when each
    point takes part in it as the median of those around it does. The first one stays.
    """
    rigid = rigid_part(now)
    beside = _beside(now, rigid)
    kept = 1
    while kept < now.courses.shape[1]:
        without, with_it = (_left(now, rigid + _first(beside, count))[0] for count in (kept, kept + 1))
        if with_it > _HALF * without:
            break
        kept += 1
    shifts = now.shifts[:, :kept]
    return replace(now, courses=now.courses[:, :kept], shifts=shifts, held_to=shifts)


def told_by_depth(now: Deforming) -> bool:
    """Whether half of the variance that the last of motions in order of their size (`by_size`) leaves in
    depth is gone as each point makes it. A track that drifts takes no path along then: errors of depth are
    each frame's own, and so small that where the track goes is seen."""
    rigid = rigid_part(now)
    own = now.shifts - rigid
    count = own.shape[1]
    without, with_it = (_left(now, rigid + _first(own, kept))[1] for kept in (count - 1, count))
    return bool(with_it <= _HALF * without)


def _first(shifts: FloatArray, count: int) -> FloatArray:
    """Of shifts (P, K, 3), those of the first motions; the others' are 0."""
    return np.where(np.arange(shifts.shape[1])[:, None] < count, shifts, 0.0)


def by_size(now: Deforming) -> Deforming:
    """The motions in order of how far neighbours go together (principal components), the largest first, over
    courses of mean 0 and size 1."""
    now = by_speed(now)
    beside = _beside(now, rigid_part(now))
    axes = np.linalg.eigh(np.einsum("pki,pli->kl", beside, beside))[1][:, ::-1]
    shifts = np.einsum("pki,kl->pli", now.shifts, axes)
    return replace(now, courses=now.courses @ axes, shifts=shifts, held_to=shifts)


def _beside(now: Deforming, rigid: FloatArray) -> FloatArray:
    """(P, K, 3), the median of those around each point of the shifts less `rigid` (P, K, 3)."""
    around = (now.shifts - rigid)[nearest(now.rest.astype(np.float32))]
    return np.asarray(np.median(around, axis=1))


def _left(now: Deforming, shifts: FloatArray) -> FloatArray:
    """(2,) px and inverse depth in the median, where points are shifted so, and rest where that fits what was
    found best."""
    change = np.einsum("nk,nki->ni", now.courses[now.frames], (now.shifts - shifts)[now.points])
    count = np.bincount(now.points, minlength=len(now.rest))
    mean = summed(change, now.points, len(now.rest)) / np.maximum(count, 1)[:, None]
    there = replace(now, shifts=shifts, rest=now.rest + mean)
    off, known = np.abs(there.apart()), now.seen.weights[:, 2] > 0
    sizes = np.median(off[:, :2]), np.median(off[known, 2]) if known.any() else 0.0
    return np.maximum(sizes, 1e-12)
