"""What of a motion that all tissue takes up as one rigid body is the camera's, and what the tissue's.

What is seen is the same whether the camera moves by a time course or all tissue does, against it. A motion
that is much faster than the camera, as breathing is, is the tissue's: the camera's path is smooth without it.
Of a slower one, such as a pull, the camera has the part that leaves the most tissue at rest and the rest
pulled one way. Across that way, tissue that is dragged along tells as well where the camera is. Along it, a
part that is too large shows: tissue seems to go the other way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np

from renderer.camera import FloatArray, IntArray
from renderer.poses.deforming import Deforming
from renderer.poses.outlying_points import nearest
from renderer.poses.resection import OUTLYING, TO_DEVIATION, trust
from renderer.poses.rigid_motion import inverse, motion_slopes

_FASTER: Final = 2.0
"""Times as fast as the camera's path: of phantoms that breathe 6 times in its round 6, of their pulls 1."""
_RESTING: Final = 0.04
"""Share of the tissue that tells what rests at last: less agrees by chance. Of two phantoms of 600 frames
that are pulled, depth off by 0.3 px, 0.08 leaves 0.76 and 0.69 % of the path as error before all is fitted
again, 0.04 leaves 0.61 and 0.59 %, 0.02 leaves 0.60 and 0.50 %."""
_NARROWED: Final = 0.8
"""Times the scale, each (graduated non-convexity; Blake and Zisserman, "Visual Reconstruction", 1987)."""
_AROUND: Final = 8
"""Points, as far as which one stands for tissue. Counting points instead of this leaves 1.15 % for 0.37."""
_LARGEST: Final = 4.0
"""Times the mean area."""
_AGAINST: Final = 0.1
"""Of a point at rest, how much one counts at least that moves against the others. Of those phantoms 0 leaves
0.90 and 1.16 %."""
_BEYOND: Final = 0.5
"""Times the noise, by which it must."""
_ASIDE: Final = 2.0
"""Times as far as tissue goes aside in the mean for how far it goes along: as far one may. Of those phantoms
1 leaves 0.56 and 0.58 %, 4 leaves 0.66 and 0.64 %. Of made-up tissue that bulges aside, 1 leaves 0.41 %, 2
leaves 0.16 %, 4 leaves 0.11 %."""
_STRAY: Final = 3.0
"""Times the noise: a point that differs by that from those around it counts a quarter then."""
_ROUNDS = 30
_SMALLEST = 1e-6
"""Of the typical distance: nothing is known to rest as exactly."""


def divided(now: Deforming) -> Deforming:
    """The same places in each frame's camera, to first order; shifts are held to what they are then."""
    now = by_speed(now)
    fast = fast_motions(now)
    if fast:
        now = _smoothed_path(now, fast)
    turns = motion_slopes(now.rest - now.rest.mean(axis=0))
    areas, near = _areas(now.rest), nearest(now.rest.astype(np.float32))
    for motion in range(len(fast), now.courses.shape[1]):
        rigid = np.zeros((now.courses.shape[1], 6))
        rigid[motion] = _resting(turns, now.shifts[:, motion], areas, near)
        now = _shared(now, rigid)
    return replace(now, held_to=now.shifts)


def by_speed(now: Deforming) -> Deforming:
    """Motions that differ in speed as far as they can, the fastest first; courses of mean 0 and size 1."""
    mean = now.courses.mean(axis=0)
    courses = now.courses - mean
    steps = np.diff(courses, axis=0)
    root = np.linalg.inv(np.linalg.cholesky(courses.T @ courses / len(courses)))
    axes = np.linalg.eigh(root @ (steps.T @ steps) @ root.T)[1][:, ::-1]
    mixed = root.T @ axes
    shifts = np.einsum("kj,pji->pki", np.linalg.inv(mixed), now.shifts)
    rest = now.rest + np.einsum("k,pki->pi", mean, now.shifts)
    return replace(now, courses=courses @ mixed, rest=rest, shifts=shifts, held_to=shifts)


def fast_motions(now: Deforming) -> list[int]:
    """Of motions in order of their speed (`by_speed`), the first ones, that are much faster than the camera's
    path is without them."""
    fast = list[int]()
    for motion in range(now.courses.shape[1]):
        smoother = _smoothed_path(now, [*fast, motion])
        if _speeds(now.courses)[motion] < _FASTER * _speeds(_path(smoother)[:, 3:], together=True)[0]:
            break
        fast.append(motion)
    return fast


def _speeds(series: FloatArray, *, together: bool = False) -> FloatArray:
    """(K,) how much each of a series (F, K) changes from one frame to the next, over its size; or all
    `together`, (1,)."""
    changes, sizes = (
        (each**2).sum(axis=0) for each in (np.diff(series, axis=0), series - series.mean(axis=0))
    )
    if together:
        changes, sizes = (each.sum(keepdims=True) for each in (changes, sizes))
    return np.asarray(np.sqrt(changes / np.maximum(sizes, 1e-12)))


def _path(now: Deforming) -> FloatArray:
    """(F, 6): turns of the cameras, in radians from that of the middle one, and where they are."""
    middle = now.poses[len(now.poses) // 2, :3, :3]
    turns = [cv2.Rodrigues(middle.T @ pose[:3, :3])[0][:, 0] for pose in now.poses]
    places = [inverse(pose)[:3, 3] for pose in now.poses]
    return np.concatenate([np.array(turns), np.array(places)], axis=1)


def _smoothed_path(now: Deforming, fast: Sequence[int]) -> Deforming:
    """With what these motions share as a rigid body divided so that the path bends least."""
    around = now.rest - now.rest.mean(axis=0)
    lever = np.linalg.norm(around, axis=1).mean()
    path = _path(now)
    change = motion_slopes(path[:, 3:] - now.rest.mean(axis=0))
    path = path * np.r_[[lever] * 3, [1.0] * 3]
    change = np.concatenate([np.broadcast_to(-lever * np.eye(3, 6), change.shape), change], axis=1)
    effects = np.concatenate([now.courses[:, motion, None, None] * change for motion in fast], axis=2)
    bends = np.diff(effects, 2, axis=0).reshape(-1, 6 * len(fast))
    found = np.linalg.lstsq(bends, -np.diff(path, 2, axis=0).ravel(), rcond=None)[0]
    rigid = np.zeros((now.courses.shape[1], 6))
    rigid[fast] = found.reshape(-1, 6)
    return _shared(now, rigid)


def rigid_part(now: Deforming) -> FloatArray:
    """(P, K, 3) of the shifts, what is nearest to a turn and a shift of all points."""
    turns = motion_slopes(now.rest - now.rest.mean(axis=0))
    even = np.broadcast_to(np.eye(3), (len(now.rest), 3, 3))
    parts = [-turns @ _weighted(turns, shifts, even) for shifts in now.shifts.swapaxes(0, 1)]
    return np.stack(parts, axis=1)


def _areas(places: FloatArray) -> FloatArray:
    """(P,) about how much tissue each point stands for, in shares of the mean: features crowd where tissue
    has texture, and say no more together."""
    apart = ((places[:, None] - places) ** 2).sum(axis=2)
    area = np.sort(apart, axis=1)[:, min(_AROUND, len(places) - 1)]
    return np.minimum(area / max(float(area.mean()), 1e-12), _LARGEST)


def _resting(turns: FloatArray, shifts: FloatArray, areas: FloatArray, near: IntArray) -> FloatArray:
    """(6,) the rigid motion that, on top of shifts (P, 3), leaves the most tissue where it is, and the rest
    moved one way; `turns`: how it moves each point (P, 3, 6); `near` (P, N): points around each.

    From all points on, ever less motion counts as rest. What a point does not share with those around it is
    noise, of which depth may have more than places.
    """
    noise = np.median(np.abs(shifts - _beside(shifts, near)), axis=0) + _SMALLEST
    exact = noise.min() / noise
    shifts, turns = shifts * exact, turns * exact[:, None]
    first = _weighted(turns, shifts, areas[:, None, None] * np.eye(3))
    field = _field(shifts + turns @ first, areas, near)
    found = kept = np.zeros(6)
    scale = 2 * float(np.linalg.norm(field.left, axis=1).max())
    while scale > _SMALLEST:
        for _ in range(_ROUNDS):
            before = found
            found = _weighted(turns, field.left, field.moved(turns @ found).counts(scale))
            if np.abs(found - before).max() < 1e-4 * scale:
                break
        if areas @ _small(field.moved(turns @ found).beside, scale) < _RESTING * areas.sum():
            break
        kept, scale = found, scale * _NARROWED
    return first + kept


@dataclass(frozen=True, eq=False)
class _Field:
    """How far points moved."""

    left: FloatArray
    """(P, 3)."""
    beside: FloatArray
    """(P, 3), those around each."""
    areas: FloatArray
    """(P,) of the tissue."""
    alike: FloatArray
    """(P,) in [0, 1], whether a point moves as those around it do."""
    noise: float
    """Standard deviation of a point from those."""

    def moved(self, further: FloatArray) -> _Field:
        """By (P, 3)."""
        return replace(self, left=self.left + further, beside=self.beside + further)

    def counts(self, scale: float) -> FloatArray:
        """(P, 3, 3) how much each point counts, by directions: in all where those around it are at rest, as
        motions of `scale` are, or go against the others; elsewhere across the way that most go, the less the
        farther they go."""
        way = self._way()
        across = np.eye(3) - np.outer(way, way)
        aside, along = ((self.beside @ across) ** 2).sum(axis=1), (self.beside @ way) ** 2
        against = np.where(self.beside @ way < -_BEYOND * self.noise, _AGAINST, 0.0)
        rests = self.alike * np.maximum(_small(self.beside, scale), against)
        moved = self.areas * (self.alike - rests)
        stray = _ASIDE**2 * (moved @ aside) / max(float(moved @ along), 1e-12)
        one_way = moved * scale**2 / (scale**2 + stray * along)
        in_all = (self.areas * rests)[:, None, None] * np.eye(3)
        return np.asarray(in_all + one_way[:, None, None] * across)

    def _way(self) -> FloatArray:
        """(3,) of length 1, the way that most goes."""
        much = (self.areas * self.alike * np.linalg.norm(self.left, axis=1))[:, None] * self.left
        way = np.linalg.eigh(self.left.T @ much)[1][:, -1]
        return np.asarray(way if much.sum(axis=0) @ way > 0 else -way)


def _field(left: FloatArray, areas: FloatArray, near: IntArray) -> _Field:
    beside = _beside(left, near)
    apart = np.linalg.norm(left - beside, axis=1)
    noise = max(TO_DEVIATION * float(np.median(apart)), _SMALLEST)
    return _Field(left, beside, areas, _small(apart, _STRAY * noise), noise)


def _beside(shifts: FloatArray, near: IntArray) -> FloatArray:
    """(P, 3), the median of those around each point."""
    return np.asarray(np.median(shifts[near], axis=1))


def _small(sizes: FloatArray, scale: float) -> FloatArray:
    """(P,) in [0, 1], of lengths (P,) or vectors (P, 3)."""
    squared = sizes**2 if sizes.ndim == 1 else (sizes**2).sum(axis=1)
    return trust(squared * (OUTLYING / scale) ** 2)


def _weighted(turns: FloatArray, shifts: FloatArray, counts: FloatArray) -> FloatArray:
    """(6,) the rigid motion against shifts (P, 3) of points that count so much, by directions (P, 3, 3)."""
    by_turns = turns.swapaxes(1, 2) @ counts
    normal = (by_turns @ turns).sum(axis=0) + 1e-12 * np.eye(6)
    return np.asarray(-np.linalg.solve(normal, np.einsum("pij,pj->i", by_turns, shifts)))


def _shared(now: Deforming, rigid: FloatArray) -> Deforming:
    """Each motion (K, 6), a turn in radians and a shift, is the tissue's from now on rather than the
    camera's."""
    middle = now.rest.mean(axis=0)
    shifts = now.shifts + np.einsum("pij,kj->pki", motion_slopes(now.rest - middle), rigid)
    poses = [
        pose @ _back(course @ rigid, middle) for pose, course in zip(now.poses, now.courses, strict=True)
    ]
    return replace(now, shifts=shifts, poses=np.stack(poses))


def _back(motion: FloatArray, middle: FloatArray) -> FloatArray:
    """(4, 4), the inverse of a turn about `middle` (3,) and a shift."""
    there = np.eye(4)
    there[:3, :3] = cv2.Rodrigues(motion[:3])[0]
    there[:3, 3] = middle + motion[3:] - there[:3, :3] @ middle
    return inverse(there)
