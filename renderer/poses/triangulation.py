"""Points from where cameras of known poses see them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from renderer.camera import Camera, FloatArray, IntArray
from renderer.poses.rigid_motion import local, projected
from renderer.poses.two_views import rays


@dataclass(frozen=True, eq=False)
class Triangulated:
    """What is known of each of L points; meaningless for those that fewer than two views see."""

    where: FloatArray
    """(L, 3) in world coordinates."""
    angle: FloatArray
    """(L,) in radians, about the widest between two rays to it; 0 where fewer than two views see it."""
    spread: FloatArray
    """(L,) in radians, root of the summed squares of the angles between rays to it and their mean."""
    misfit: FloatArray
    """(L,) px, root mean square of the distance from where it is seen; inf behind a camera."""

    def depth_error(self, lens: Camera) -> FloatArray:
        """(L,) share of its depth by which each point may be off: as much as would move it in the images by
        its misfit, all of which is taken to lie along the way that tells depth."""
        told = lens.fx * np.maximum(self.spread, 1e-12)
        return np.asarray(self.misfit / told)


def triangulated(
    lens: Camera,
    poses: FloatArray,
    points: IntArray,
    places: FloatArray,
    count: int,
) -> Triangulated:
    """Of `count` points, seen at (N, 2) px: the numbers (N,) of the points, one pose (N, 4, 4) each.

    The point that minimizes the algebraic error of all its views (Hartley and Zisserman, 2004, 12.2).
    """
    seen = rays(lens, places)
    x, y = (seen[:, :2] / seen[:, 2:]).T
    rows = np.stack([x[:, None] * poses[:, 2] - poses[:, 0], y[:, None] * poses[:, 2] - poses[:, 1]], axis=1)
    system = np.zeros((count, 4, 4))
    np.add.at(system, points, np.einsum("nri,nrj->nij", rows, rows))
    found = np.linalg.eigh(system)[1][:, :, 0]
    scale = np.where(np.abs(found[:, 3]) > 1e-12, found[:, 3], 1e-12)
    return judged(lens, found[:, :3] / scale[:, None], poses, points, places)


def judged(
    lens: Camera, where: FloatArray, poses: FloatArray, points: IntArray, places: FloatArray
) -> Triangulated:
    """The same of points (L, 3) that are known."""
    angle, spread = _angles(rays(lens, places), poses, points, len(where))
    return Triangulated(where, angle, spread, _misfits(lens, where, poses, points, places))


def _angles(
    seen: FloatArray, poses: FloatArray, points: IntArray, count: int
) -> tuple[FloatArray, FloatArray]:
    """(L,) twice the farthest ray from the mean of a point's rays, and the root of their summed squares."""
    toward = np.einsum("nji,nj->ni", poses[:, :3, :3], seen)
    mean = np.zeros((count, 3))
    np.add.at(mean, points, toward)
    mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-12)
    apart = np.linalg.norm(toward - mean[points], axis=1)
    widest, squares = np.zeros(count), np.zeros(count)
    np.maximum.at(widest, points, apart)
    np.add.at(squares, points, apart**2)
    return 2 * widest, np.sqrt(squares)


def _misfits(
    lens: Camera, where: FloatArray, poses: FloatArray, points: IntArray, places: FloatArray
) -> FloatArray:
    there = local(poses, where[points])
    off = ((projected(lens, there)[:, :2] - places) ** 2).sum(axis=1)
    off[there[:, 2] <= 0] = np.inf
    number = np.bincount(points, minlength=len(where))
    total = np.zeros(len(where))
    np.add.at(total, points, off)
    return np.asarray(np.sqrt(total / np.maximum(number, 1)))
