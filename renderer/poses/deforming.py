"""Poses, points and the few ways in which tissue moves, brought to agree at once.

A point rests somewhere and is shifted from there along directions of its own, by time courses that all points
share: those of breathing, of a pull (Bregler, Hertzmann and Biermann, "Recovering non-rigid 3D shape from
image streams", 2000). Points are eliminated (Schur), as in bundle.py. What is seen does not tell a shift that
all tissue takes up as one rigid body from a motion of the camera by the same time course: rigid_share.py.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from renderer.camera import Camera, FloatArray, IntArray
from renderer.poses.bundle import along, summed
from renderer.poses.resection import robust, trust
from renderer.poses.rigid_motion import Seen, local, motion_slopes, moved, projected, slopes

_ENOUGH = 1e-4
"""Of the cost: a smaller gain ends the search."""
_SHIFT = 0.1
"""Of the typical distance: the standard deviation of shifts before anything is seen, about those held to."""
_DAMPING, _MOST_DAMPING = 1e-4, 1e4
POSE: Final = 6
"""Unknowns of a pose, before those of the courses of its frame."""


@dataclass(frozen=True, eq=False)
class Deforming:
    """Frames, points, and what the frames show of them. Each frame shows a point once at most."""

    lens: Camera
    poses: FloatArray
    """(F, 4, 4), camera from world; the first one stays."""
    courses: FloatArray
    """(F, K), how far each of K motions is at each frame."""
    rest: FloatArray
    """(P, 3) in world coordinates."""
    shifts: FloatArray
    """(P, K, 3) by which a motion at 1 shifts each point."""
    held_to: FloatArray
    """(P, K, 3), shifts that these leave only as far as what is seen tells."""
    frames: IntArray
    """(N,) which frame each observation is of."""
    points: IntArray
    """(N,) and of which point."""
    seen: Seen
    """N observations."""

    def places(self) -> FloatArray:
        """(N, 3) in world coordinates, where each observation has its point."""
        shift = np.einsum("nk,nki->ni", self.courses[self.frames], self.shifts[self.points])
        return np.asarray(self.rest[self.points] + shift)

    def apart(self) -> FloatArray:
        """(N, 3) measured minus expected: px, px, inverse depth; meaningless where that is not measured."""
        there = local(self.poses[self.frames], self.places())
        return np.asarray(self.seen.measured - projected(self.lens, there))


def fitted(start: Deforming, rounds: int, *, points_stay: bool = False) -> Deforming:
    """Levenberg and Marquardt's method on the robust cost; never a higher one than that of `start`.
    `points_stay`: only poses and courses are sought."""
    now, damping, cost = start, _DAMPING, _cost(start)
    step = _stepped_frames if points_stay else _stepped
    for _ in range(rounds):
        other = step(now, damping)
        lower = _cost(other)
        if not lower < cost:
            damping *= 10
            if damping > _MOST_DAMPING:
                break
            continue
        is_done = cost - lower < _ENOUGH * cost
        now, cost, damping = other, lower, max(damping / 10, 1e-8)
        if is_done:
            break
    return now


def _cost(now: Deforming) -> float:
    left = ((now.apart() * now.seen.weights) ** 2).sum(axis=1)
    departed = (((now.shifts - now.held_to) / _SHIFT) ** 2).sum()
    return float(robust(left).sum() + departed + (now.courses**2).sum())


@dataclass(frozen=True, eq=False)
class _Slopes:
    """How what is seen changes with the unknowns, over its standard deviation and by its trust."""

    left: FloatArray
    """(N, 3)."""
    by_frame: FloatArray
    """(N, 3, 6 + K)."""
    by_place: FloatArray
    """(N, 3, 3)."""


def _slopes(now: Deforming) -> _Slopes:
    left = now.apart() * now.seen.weights
    share = np.sqrt(trust((left**2).sum(axis=1)))[:, None]
    poses = now.poses[now.frames]
    there = local(poses, now.places())
    change = slopes(now.lens, there) * (now.seen.weights * share)[:, :, None]
    by_place = change @ poses[:, :3, :3]
    by_course = by_place @ now.shifts[now.points].swapaxes(1, 2)
    by_frame = np.concatenate([change @ motion_slopes(there), by_course], axis=2)
    return _Slopes(left * share, by_frame, by_place)


def _frame_equations(now: Deforming, slope: _Slopes, damping: float) -> tuple[FloatArray, FloatArray]:
    """(F, 6 + K, 6 + K) and (F, 6 + K), of each frame alone."""
    own = summed(slope.by_frame.swapaxes(1, 2) @ slope.by_frame, now.frames, len(now.poses))
    against = summed(along(slope.by_frame, slope.left), now.frames, len(now.poses))
    courses = np.arange(POSE, own.shape[1])
    own[:, courses, courses] += 1.0
    against[:, POSE:] -= now.courses
    return _damped(own, damping), against


def _stepped_frames(now: Deforming, damping: float) -> Deforming:
    own, against = _frame_equations(now, _slopes(now), damping)
    return _with_frames(now, np.asarray(np.linalg.solve(own, against[:, :, None])[:, :, 0]))


def _with_frames(now: Deforming, step: FloatArray) -> Deforming:
    poses = np.stack([moved(pose, each) for pose, each in zip(now.poses, step[:, :POSE], strict=True)])
    return replace(now, poses=poses, courses=now.courses + step[:, POSE:])


def _stepped(now: Deforming, damping: float) -> Deforming:
    slope = _slopes(now)
    own, against = _frame_equations(now, slope, damping)
    factors = np.concatenate([np.ones((len(now.frames), 1)), now.courses[now.frames]], axis=1)
    by_point = factors[:, None, :, None] * slope.by_place[:, :, None, :]
    by_point = by_point.reshape(len(now.frames), 3, -1)
    count, unknowns, width = len(now.rest), by_point.shape[2], own.shape[1]
    of_points = summed(by_point.swapaxes(1, 2) @ by_point, now.points, count)
    pull = summed(along(by_point, slope.left), now.points, count)
    motions = np.arange(3, unknowns)
    of_points[:, motions, motions] += _SHIFT**-2
    pull[:, 3:] -= (now.shifts - now.held_to).reshape(count, -1) / _SHIFT**2
    inverse = np.linalg.inv(_damped(of_points, damping))
    across = np.zeros((count, unknowns, len(now.poses), width))
    across[now.points, :, now.frames] = by_point.swapaxes(1, 2) @ slope.by_frame
    coupling = across.reshape(count, unknowns, -1)
    offset = np.einsum("pij,pj->pi", inverse, pull)

    roots = np.linalg.cholesky(inverse).swapaxes(1, 2) @ coupling
    flat = roots.reshape(-1, roots.shape[2])
    stiffness = -(flat.T @ flat)
    for place, block in enumerate(own):
        here = slice(width * place, width * (place + 1))
        stiffness[here, here] += block
    said = against.ravel() - np.einsum("pij,pi->j", coupling, offset)
    step = np.zeros(len(said))
    step[POSE:] = np.linalg.solve(stiffness[POSE:, POSE:], said[POSE:])
    change = offset - np.einsum("pij,pj->pi", inverse, coupling @ step)
    change = change.reshape(count, -1, 3)
    there = _with_frames(now, step.reshape(-1, width))
    return replace(there, rest=now.rest + change[:, 0], shifts=now.shifts + change[:, 1:])


def _damped(equations: FloatArray, damping: float) -> FloatArray:
    diagonal = np.einsum("njj->nj", equations)
    diagonal *= 1 + damping
    diagonal += 1e-9
    return equations
