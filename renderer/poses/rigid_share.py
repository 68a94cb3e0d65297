"""What of a motion that all tissue takes up as one rigid body is the camera's, and what the tissue's.

What is seen is the same whether the camera moves by a time course or all tissue does, against it. A motion
that is much faster than the camera, as breathing is, is the tissue's: the camera's path is smooth without it.
Of a slower one, such as a pull, the camera has the part that leaves the most tissue at rest, and little
moved against the pull: where that part is too large, tissue that was dragged along seems to go the other way.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import cv2
import numpy as np

from renderer.camera import FloatArray, IntArray
from renderer.poses.deforming import Deforming
from renderer.poses.outlying_points import nearest
from renderer.poses.resection import OUTLYING, trust
from renderer.poses.rigid_motion import inverse, motion_slopes

_FASTER: Final = 2.0
"""Times as fast as the camera's path: of phantoms that breathe 6 times in its round 6, of their pulls 1."""
_RESTING: Final = 0.04
"""Share of the tissue that tells what rests at last: less agrees by chance. Of two phantoms that are pulled,
0.08 leaves 0.44 and 0.52 % of the path as error, 0.04 leaves 0.38 and 0.37 %, 0.02 leaves 0.41 and 0.36 %."""
_NARROWED: Final = 0.8
"""Times the scale, each (graduated non-convexity; Blake and Zisserman, "Visual Reconstruction", 1987)."""
_AROUND: Final = 8
"""Points, as far as which one stands for tissue. Counting points instead of this leaves 1.15 % for 0.37."""
_LARGEST: Final = 4.0
"""Times the mean area."""
_AGAINST: Final = 0.1
"""Of a point at rest, how much one counts at least that moves against the others."""
_BEYOND: Final = 0.5
"""Times the noise, by which it must. Of phantoms of 600 frames, where depth is off by 0.3 px, all this leaves
0.34 % of the path for 0.68 (pulled) and 0.41 for 0.58 (breathing, too); where it is exact, 0.42 and 0.40 for
0.36 and 0.39. Of 60 frames, with such depth, it leaves 1.12 and 1.36 for 0.76 and 1.17."""
_STRAY: Final = 3.0
"""Times the noise: a point that differs by that from those around it counts a quarter then."""
_TO_DEVIATION: Final = 1.4826
"""From the median of absolute values to the standard deviation, of a normal distribution."""
_ROUNDS = 30
_SMALLEST = 1e-6
"""Of the typical distance: nothing is known to rest as exactly."""


def divided(now: Deforming) -> Deforming:
    """The same places in each frame's camera, to first order; shifts are held to what they are then."""
    now = _by_speed(now)
    fast = list[int]()
    for motion in range(now.courses.shape[1]):
        smoother = _smoothed_path(now, [*fast, motion])
        if _speeds(now.courses)[motion] < _FASTER * _speeds(_path(smoother)[:, 3:], together=True)[0]:
            break
        fast.append(motion)
    if fast:
        now = _smoothed_path(now, fast)
    turns = motion_slopes(now.rest - now.rest.mean(axis=0))
    areas, near = _areas(now.rest), nearest(now.rest.astype(np.float32))
    for motion in range(len(fast), now.courses.shape[1]):
        rigid = np.zeros((now.courses.shape[1], 6))
        rigid[motion] = _resting(turns, now.shifts[:, motion], areas, near)
        now = _shared(now, rigid)
    return replace(now, held_to=now.shifts)


def _by_speed(now: Deforming) -> Deforming:
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
    even = np.ones(len(now.rest))
    parts = [-turns @ _weighted(turns, shifts, even) for shifts in now.shifts.swapaxes(0, 1)]
    return np.stack(parts, axis=1)


def _areas(places: FloatArray) -> FloatArray:
    """(P,) about how much tissue each point stands for, in shares of the mean: features crowd where tissue
    has texture, and say no more together."""
    apart = ((places[:, None] - places) ** 2).sum(axis=2)
    area = np.sort(apart, axis=1)[:, min(_AROUND, len(places) - 1)]
    return np.minimum(area / max(float(area.mean()), 1e-12), _LARGEST)


def _resting(turns: FloatArray, shifts: FloatArray, areas: FloatArray, near: IntArray) -> FloatArray:
    """(6,) the rigid motion that, on top of shifts (P, 3), leaves the most tissue where it is, and little
    moved against the others; `turns`: how it moves each point (P, 3, 6); `near` (P, N): points around each.

    What a point does not share with those around it is noise, of which depth may have more than places.
    """
    noise = np.median(np.abs(shifts - _beside(shifts, near)), axis=0) + _SMALLEST
    exact = noise.min() / noise
    shifts, turns = shifts * exact, turns * exact[:, None]
    first = _least_moving(turns, shifts, areas, lambda _: np.zeros(len(shifts)))
    left = shifts + turns @ first
    beside = _beside(left, near)
    apart = np.linalg.norm(left - beside, axis=1)
    spread = max(_TO_DEVIATION * float(np.median(apart)), _SMALLEST)
    counted = _AGAINST * trust((apart * OUTLYING / (_STRAY * spread)) ** 2)
    way = (areas * np.linalg.norm(left, axis=1)) @ left
    way /= max(float(np.linalg.norm(way)), 1e-12)

    def against(found: FloatArray) -> FloatArray:
        return np.where((beside + turns @ (found - first)) @ way < -_BEYOND * spread, counted, 0.0)

    return _least_moving(turns, shifts, areas, against)


def _least_moving(
    turns: FloatArray, shifts: FloatArray, areas: FloatArray, least: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """As _resting: from all points on, ever less motion counts as rest; a point counts at `least` so
    much (P,), by the motion that is found."""
    found = kept = _weighted(turns, shifts, areas)
    scale = 2 * float(np.linalg.norm(shifts + turns @ found, axis=1).max())
    while scale > _SMALLEST:
        for _ in range(_ROUNDS):
            before = found
            counts = np.maximum(_rests(shifts + turns @ found, scale), least(found))
            found = _weighted(turns, shifts, areas * counts)
            if np.abs(found - before).max() < 1e-4 * scale:
                break
        if areas @ _rests(shifts + turns @ found, scale) < _RESTING * areas.sum():
            break
        kept, scale = found, scale * _NARROWED
    return kept


def _beside(shifts: FloatArray, near: IntArray) -> FloatArray:
    """(P, 3), the median of those around each point."""
    return np.asarray(np.median(shifts[near], axis=1))


def _rests(shifts: FloatArray, scale: float) -> FloatArray:
    """(P,) in [0, 1]."""
    squared: FloatArray = (shifts**2).sum(axis=1)
    return trust(squared * (OUTLYING / scale) ** 2)


def _weighted(turns: FloatArray, shifts: FloatArray, weights: FloatArray) -> FloatArray:
    normal = np.einsum("p,pij,pik->jk", weights, turns, turns) + 1e-12 * np.eye(6)
    return np.asarray(-np.linalg.solve(normal, np.einsum("p,pij,pi->j", weights, turns, shifts)))


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
