"""The pose from which a camera sees known points where it sees them, some of which moved or were confused."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.clip import BoolImage
from renderer.poses.rigid_motion import Seen, local, motion_slopes, moved, projected, slopes

OUTLYING = 3.0
"""Standard deviations from which a point speaks against a pose rather than about it."""
TO_DEVIATION = 1.4826
"""From the median of absolute values to the standard deviation, of a normal distribution."""
FEWEST = 12
"""Points that a pose is found from at least."""
_STAGES = 4
"""In each the scale of the cost follows what is left over."""
_ROUNDS = 15
_ENOUGH = 1e-7
_MEDIAN_OF_THREE = 1.538
"""Of the length of three normally distributed numbers."""
_TRIED = 200
_RANSAC_PX = 3.0


@dataclass(frozen=True, eq=False)
class Resected:
    """A pose and how well it fits."""

    pose: FloatArray
    """(4, 4), camera from world."""
    inliers: BoolImage
    """(N,), points that agree with it."""
    misfit: float
    """Median over the points, in standard deviations: what more than half of them moved on their own."""


def resected(lens: Camera, points: FloatArray, seen: Seen, starts: list[FloatArray]) -> Resected:
    """The best pose of a camera that sees points (N, 3), N >= FEWEST, where they are `seen`.

    From each of the starts (4, 4), Levenberg and Marquardt's method goes down the robust cost of Geman
    and McClure, whose scale follows the median misfit, as tissue deforms; the least median wins.
    """
    return min((_refined(lens, points, seen, start) for start in starts), key=lambda found: found.misfit)


def by_chance(lens: Camera, points: FloatArray, seen: Seen) -> list[FloatArray]:
    """The pose (4, 4) of three points that most others agree with (RANSAC, Fischler and Bolles, 1981), in the
    same order every time; none where there is no such."""
    pixels = np.ascontiguousarray(seen.measured[:, :2])
    try:
        found, turn, shift, _ = cv2.solvePnPRansac(
            np.ascontiguousarray(points), pixels, lens.intrinsics, np.zeros(4),
            iterationsCount=_TRIED, reprojectionError=_RANSAC_PX, flags=cv2.SOLVEPNP_AP3P,
        )  # fmt: skip
    except cv2.error:  # Points from which no pose follows.
        return []
    if not found or not (np.isfinite(turn).all() and np.isfinite(shift).all()):
        return []
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(turn)[0], shift[:, 0]
    return [pose]


def residuals(lens: Camera, places: FloatArray, seen: Seen) -> FloatArray:
    """(N, 3) in standard deviations, of points at `places` (N, 3) in camera axes; 0 where not measured."""
    return np.asarray((seen.measured - projected(lens, places)) * seen.weights)


def trust(squared: FloatArray) -> FloatArray:
    """Weight in [0, 1] of a residual's square, by Geman and McClure."""
    return np.asarray(1 / (1 + squared / OUTLYING**2) ** 2)


def robust(squared: FloatArray) -> FloatArray:
    """The cost of which `trust` is the slope: at most OUTLYING^2."""
    return np.asarray(squared / (1 + squared / OUTLYING**2))


def _refined(lens: Camera, points: FloatArray, seen: Seen, start: FloatArray) -> Resected:
    pose = start
    for _ in range(_STAGES):
        weighed = Seen(seen.measured, seen.weights * (1 / _scale(lens, points, seen, pose)))
        pose = _descended(lens, points, weighed, pose)
    return agreeing(lens, points, seen, pose)


def agreeing(lens: Camera, points: FloatArray, seen: Seen, pose: FloatArray) -> Resected:
    """How well this pose fits."""
    left = (residuals(lens, local(pose, points), seen) ** 2).sum(axis=1)
    scale = _scale(lens, points, seen, pose)
    return Resected(pose, left < (OUTLYING * scale) ** 2, float(np.median(np.sqrt(left))))


def _scale(lens: Camera, points: FloatArray, seen: Seen, pose: FloatArray) -> float:
    """By how much the noise is larger than assumed: the tissue deforms."""
    left = residuals(lens, local(pose, points), seen)
    return max(1.0, float(np.median(np.linalg.norm(left, axis=1))) / _MEDIAN_OF_THREE)


def _descended(lens: Camera, points: FloatArray, seen: Seen, start: FloatArray) -> FloatArray:
    pose, damping = start, 1e-3
    left = residuals(lens, local(pose, points), seen)
    cost = float(robust((left**2).sum(axis=1)).sum())
    for _ in range(_ROUNDS):
        step = _step(lens, local(pose, points), seen, left, damping)
        other = moved(pose, step)
        there = residuals(lens, local(other, points), seen)
        lower = float(robust((there**2).sum(axis=1)).sum())
        if lower > cost:
            damping *= 10
            if damping > 1e6:
                break
            continue
        is_done = cost - lower < _ENOUGH * cost or not np.abs(step).max() > _ENOUGH
        pose, left, cost, damping = other, there, lower, max(damping / 10, 1e-9)
        if is_done:
            break
    return pose


def _step(lens: Camera, places: FloatArray, seen: Seen, left: FloatArray, damping: float) -> FloatArray:
    """(6,), of Levenberg and Marquardt."""
    share = trust((left**2).sum(axis=1))
    change = (slopes(lens, places) @ motion_slopes(places)) * seen.weights[:, :, None]
    weighted = (change * share[:, None, None]).reshape(-1, 6).T
    stiffness, against = weighted @ change.reshape(-1, 6), weighted @ left.ravel()
    return np.asarray(np.linalg.solve(stiffness + damping * np.diag(np.diag(stiffness) + 1e-12), against))
