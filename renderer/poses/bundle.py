"""Poses and points at once, so that all that was seen of them agrees: bundle adjustment.

Triggs, McLauchlan, Hartley and Fitzgibbon, "Bundle adjustment: a modern synthesis", 1999. Points are
eliminated (Schur), those first seen in one view together, as they are seen in the same few others: time
and memory grow with the number of views, not with its product with the number of points.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera, FloatArray
from renderer.poses.resection import residuals, robust, trust
from renderer.poses.rigid_motion import Seen, local, motion_slopes, moved, slopes

IntArray = NDArray[np.int64]
_ROUNDS = 15
_ENOUGH = 1e-5
"""Of the cost: a smaller gain ends it."""


@dataclass(frozen=True, eq=False)
class Bundle:
    """Views, points, and what the views see of them, sorted by nothing."""

    lens: Camera
    poses: FloatArray
    """(K, 4, 4), camera from world; the first one stays."""
    points: FloatArray
    """(L, 3) in world coordinates."""
    views: IntArray
    """(N,) which view each observation is of."""
    seen_points: IntArray
    """(N,) and of which point."""
    seen: Seen
    """N observations."""


def adjusted(bundle: Bundle) -> Bundle:
    """Levenberg and Marquardt's method on the robust cost; never a higher one than that of `bundle`."""
    damping = 1e-4
    left = misfit(bundle)
    cost = _cost(left)
    groups = _groups(bundle)
    for _ in range(_ROUNDS):
        other = _stepped(bundle, left, groups, damping)
        there = misfit(other)
        lower = _cost(there)
        if not lower < cost:
            damping *= 10
            if damping > 1e4:
                break
            continue
        is_done = cost - lower < _ENOUGH * cost
        bundle, left, cost, damping = other, there, lower, max(damping / 10, 1e-8)
        if is_done:
            break
    return bundle


def misfit(bundle: Bundle) -> FloatArray:
    """(N, 3) in standard deviations."""
    return residuals(bundle.lens, _places(bundle), bundle.seen)


def _places(bundle: Bundle) -> FloatArray:
    return local(bundle.poses[bundle.views], bundle.points[bundle.seen_points])


def _cost(left: FloatArray) -> float:
    return float(robust((left**2).sum(axis=1)).sum())


def _groups(bundle: Bundle) -> list[IntArray]:
    """Observations of the points that are first seen in one view, for each view."""
    first = np.full(len(bundle.points), len(bundle.poses))
    np.minimum.at(first, bundle.seen_points, bundle.views)
    of = first[bundle.seen_points]
    order = np.argsort(of, kind="stable")
    bounds = np.searchsorted(of[order], np.arange(len(bundle.poses) + 1))
    return [order[start:end] for start, end in pairwise(bounds) if end > start]


def _stepped(bundle: Bundle, left: FloatArray, groups: list[IntArray], damping: float) -> Bundle:
    count = len(bundle.poses)
    stiffness, against = np.zeros((6 * count, 6 * count)), np.zeros(6 * count)
    backs = [_eliminate(bundle, left, group, damping, stiffness, against) for group in groups]
    free = slice(6, None)
    step = np.zeros(6 * count)
    step[free] = np.linalg.solve(stiffness[free, free], against[free])
    points = bundle.points.copy()
    for back in backs:
        points[back.points] += back.offset - np.einsum("ljk,k->lj", back.coupling, step[back.columns])
    poses = [moved(pose, each) for pose, each in zip(bundle.poses, step.reshape(-1, 6), strict=True)]
    return replace(bundle, poses=np.stack(poses), points=points)


@dataclass(frozen=True, eq=False)
class _Back:
    """How the points (P,) of a group follow from the step of the poses that see them."""

    points: IntArray
    columns: IntArray
    """(6 M,) of the M poses."""
    offset: FloatArray
    """(P, 3)."""
    coupling: FloatArray
    """(P, 3, 6 M)."""


def _eliminate(
    bundle: Bundle,
    left: FloatArray,
    group: IntArray,
    damping: float,
    stiffness: FloatArray,
    against: FloatArray,
) -> _Back:
    """Adds what one group says of the poses to the equations (6 K, 6 K) and (6 K,), its points eliminated."""
    points, of_point = np.unique(bundle.seen_points[group], return_inverse=True)
    views, of_view = np.unique(bundle.views[group], return_inverse=True)
    places = local(bundle.poses[bundle.views[group]], bundle.points[bundle.seen_points[group]])
    share = np.sqrt(trust((left[group] ** 2).sum(axis=1)))[:, None]
    weights = bundle.seen.weights[group] * share
    apart = left[group] * share
    change = slopes(bundle.lens, places) * weights[:, :, None]
    by_pose = change @ motion_slopes(places)
    by_point = change @ bundle.poses[bundle.views[group]][:, :3, :3]

    of_points = np.zeros((len(points), 3, 3))
    np.add.at(of_points, of_point, np.einsum("nij,nik->njk", by_point, by_point))
    pull = np.zeros((len(points), 3))
    np.add.at(pull, of_point, np.einsum("nij,ni->nj", by_point, apart))
    diagonal = np.einsum("ljj->lj", of_points)
    diagonal *= 1 + damping
    diagonal += 1e-9
    inverse = np.linalg.inv(of_points)
    across = np.zeros((len(points) * len(views), 3, 6))
    np.add.at(across, of_point * len(views) + of_view, np.einsum("nij,nik->njk", by_point, by_pose))
    coupling = across.reshape(len(points), len(views), 3, 6).swapaxes(1, 2).reshape(len(points), 3, -1)
    solved = inverse @ coupling
    offset = np.einsum("ljk,lk->lj", inverse, pull)

    columns = (6 * views[:, None] + np.arange(6)).ravel()
    own = np.zeros((len(views), 6, 6))
    np.add.at(own, of_view, np.einsum("nij,nik->njk", by_pose, by_pose))
    own_diagonal = np.einsum("mjj->mj", own)
    own_diagonal *= 1 + damping
    own_diagonal += 1e-9
    flat, flat_solved = coupling.reshape(-1, len(columns)), solved.reshape(-1, len(columns))
    block = -flat.T @ flat_solved
    for place in range(len(views)):
        here = slice(6 * place, 6 * place + 6)
        block[here, here] += own[place]
    stiffness[np.ix_(columns, columns)] += block
    turned = np.zeros((len(views), 6))
    np.add.at(turned, of_view, np.einsum("nij,ni->nj", by_pose, apart))
    against[columns] += turned.ravel() - np.einsum("ljk,lj->k", coupling, offset)
    return _Back(points, columns, offset, solved)
