"""Poses and points at once, so that all that was seen of them agrees: bundle adjustment.

Triggs, McLauchlan, Hartley and Fitzgibbon, "Bundle adjustment: a modern synthesis", 1999. Points are
eliminated (Schur), those first seen in one view together, as they are seen in the same few others: time
and memory grow with the number of views, not with its product with the number of points.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from renderer.camera import Camera, FloatArray, IntArray
from renderer.poses.radial import bent, bent_slopes
from renderer.poses.resection import robust, trust
from renderer.poses.rigid_motion import Seen, local, motion_slopes, moved, projected, zoomed

_ROUNDS = 15
_ENOUGH = 1e-5
"""Of the cost: a smaller gain ends it."""
_ZOOM_SPREAD = 0.3
"""Standard deviation of the logarithm of how much longer a view's own focal length is, before anything is
seen."""


@dataclass(frozen=True)
class FocalGuess:
    """A focal length that is not known, one for all views."""

    fx: float
    """px."""
    spread: float
    """Standard deviation of its logarithm: what is seen must say more than this to change it by much."""

    def off(self, lens: Camera) -> float:
        """In standard deviations, how much longer it is than that of `lens`."""
        return math.log(self.fx / lens.fx) / self.spread


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
    focal: FocalGuess | None = None
    """Where the focal length of `lens` is sought, too."""
    k1: float = 0.0
    """Radial distortion of the lens, see radial.py."""
    k1_spread: float | None = None
    """Where that is sought, too: the standard deviation of it before anything is seen, about 0."""
    longer: FloatArray | None = None
    """Where a lens zooms: (K,) logarithm of how much longer than that of `lens` the focal length of each view
    is. It is sought for each but the first."""

    @property
    def width(self) -> int:
        """Unknowns of a view."""
        return 6 if self.longer is None else 7

    def enlarged(self, expected: FloatArray, of: IntArray) -> FloatArray:
        """What `lens` shows (N, 3), as the views (N,) of these numbers do."""
        if self.longer is None:
            return expected
        middle = np.array([self.lens.cx, self.lens.cy, 0.0])
        return np.asarray(middle + (expected - middle) * self.enlargement(of))

    def enlargement(self, of: IntArray) -> FloatArray:
        """(N, 3) of columns, rows and inverse depths, which a zoom leaves as they are."""
        one = np.ones((len(of), 3))
        if self.longer is not None:
            one[:, :2] = np.exp(self.longer[of])[:, None]
        return one


def adjusted(bundle: Bundle, rounds: int = _ROUNDS, enough: float = _ENOUGH) -> Bundle:
    """Levenberg and Marquardt's method on the robust cost; never a higher one than that of `bundle`. A
    gain of less than `enough` of it ends the search.

    Where no view measures depth, the scale is free, and that of `bundle` is kept to first order.
    """
    damping = 1e-4
    left = misfit(bundle)
    cost = cost_of(bundle, left)
    groups, free = _groups(bundle), _free(bundle)
    for _ in range(rounds):
        other = _stepped(bundle, left, groups, free, damping)
        there = misfit(other)
        lower = cost_of(other, there)
        if not lower < cost:
            damping *= 10
            if damping > 1e4:
                break
            continue
        is_done = cost - lower < enough * cost
        bundle, left, cost, damping = other, there, lower, max(damping / 10, 1e-8)
        if is_done:
            break
    return bundle


def misfit(bundle: Bundle) -> FloatArray:
    """(N, 3) in standard deviations."""
    expected = bent(bundle.lens, projected(bundle.lens, _places(bundle)), bundle.k1)
    expected = bundle.enlarged(expected, bundle.views)
    return np.asarray((bundle.seen.measured - expected) * bundle.seen.weights)


def k1_pulls(bundle: Bundle) -> FloatArray:
    """(N, 3) by how much k1 of a bundle that is adjusted, of one lens, changes where a measure changes by its
    standard deviation, and all else that is sought follows."""
    left = misfit(bundle)
    stiffness, _, backs = _reduced(bundle, left, _groups(bundle), 0.0)
    free = _free(bundle)
    step = np.zeros(len(stiffness))
    step[free] = np.linalg.solve(stiffness[np.ix_(free, free)], np.eye(len(stiffness))[free, -1])
    along = np.zeros_like(bundle.points)
    for back in backs:
        along[back.points] = -np.einsum("ljk,k->lj", back.coupling, step[back.columns])
    poses = bundle.poses[bundle.views]
    places = _places(bundle)
    by_place, by_lens = bent_slopes(bundle.lens, places, bundle.k1)
    shifts = np.einsum("nij,nj->ni", motion_slopes(places), step[:-2].reshape(-1, 6)[bundle.views])
    shifts += np.einsum("nij,nj->ni", poses[:, :3, :3], along[bundle.seen_points])
    change = np.einsum("nij,nj->ni", by_place, shifts) + by_lens @ step[-2:]
    return np.asarray(change * bundle.seen.weights * trust((left**2).sum(axis=1))[:, None])


def _places(bundle: Bundle) -> FloatArray:
    return local(bundle.poses[bundle.views], bundle.points[bundle.seen_points])


def cost_of(bundle: Bundle, left: FloatArray) -> float:
    """What `adjusted` makes small; `left`: see `misfit`."""
    of_focal = 0.0 if bundle.focal is None else bundle.focal.off(bundle.lens) ** 2
    of_k1 = 0.0 if bundle.k1_spread is None else (bundle.k1 / bundle.k1_spread) ** 2
    of_zoom = 0.0 if bundle.longer is None else float((bundle.longer**2).sum()) / _ZOOM_SPREAD**2
    return float(robust((left**2).sum(axis=1)).sum()) + of_focal + of_k1 + of_zoom


def _free(bundle: Bundle) -> IntArray:
    """Of the unknowns of the K views, the focal length and k1, those that are sought; those of views that see
    nothing are not."""
    count, width = len(bundle.poses), bundle.width
    blind = np.bincount(bundle.views, minlength=count) == 0
    held = [*range(width), *(width * np.flatnonzero(blind)[:, None] + np.arange(width)).ravel()]
    if count > 1 and not (bundle.seen.weights[:, 2] > 0).any():
        places = -np.einsum("kji,kj->ki", bundle.poses[:, :3, :3], bundle.poses[:, :3, 3])
        far = int(np.argmax(np.where(blind, -1.0, np.linalg.norm(places - places[0], axis=1))))
        toward = bundle.poses[far, :3, :3] @ (places[far] - places[0])
        held.append(width * far + 3 + int(np.argmax(np.abs(toward))))
    if bundle.focal is None:
        held.append(width * count)
    if bundle.k1_spread is None:
        held.append(width * count + 1)
    return np.setdiff1d(np.arange(width * count + 2), held)


def _groups(bundle: Bundle) -> list[IntArray]:
    """Observations of the points that are first seen in one view, for each view."""
    first = np.full(len(bundle.points), len(bundle.poses))
    np.minimum.at(first, bundle.seen_points, bundle.views)
    of = first[bundle.seen_points]
    order = np.argsort(of, kind="stable")
    bounds = np.searchsorted(of[order], np.arange(len(bundle.poses) + 1))
    return [order[start:end] for start, end in pairwise(bounds) if end > start]


def _stepped(
    bundle: Bundle, left: FloatArray, groups: list[IntArray], free: IntArray, damping: float
) -> Bundle:
    stiffness, against, backs = _reduced(bundle, left, groups, damping)
    step = np.zeros(len(against))
    step[free] = np.linalg.solve(stiffness[np.ix_(free, free)], against[free])
    points = bundle.points.copy()
    for back in backs:
        points[back.points] += back.offset - np.einsum("ljk,k->lj", back.coupling, step[back.columns])
    steps = step[:-2].reshape(-1, bundle.width)
    poses = [moved(pose, each[:6]) for pose, each in zip(bundle.poses, steps, strict=True)]
    lens = bundle.lens if bundle.focal is None else zoomed(bundle.lens, step[-2])
    return replace(
        bundle, lens=lens, poses=np.stack(poses), points=points, k1=bundle.k1 + float(step[-1]),
        longer=None if bundle.longer is None else bundle.longer + steps[:, 6],
    )  # fmt: skip


def _reduced(
    bundle: Bundle, left: FloatArray, groups: list[IntArray], damping: float
) -> tuple[FloatArray, FloatArray, list[_Back]]:
    """The equations of views and lens, (U, U) and (U,), and how the points follow."""
    unknowns = bundle.width * len(bundle.poses) + 2
    stiffness, against = np.zeros((unknowns, unknowns)), np.zeros(unknowns)
    backs = [_eliminate(bundle, left, group, damping, stiffness, against) for group in groups]
    if bundle.focal is not None:
        stiffness[-2, -2] += bundle.focal.spread**-2
        against[-2] += bundle.focal.off(bundle.lens) / bundle.focal.spread
    if bundle.k1_spread is not None:
        stiffness[-1, -1] += bundle.k1_spread**-2
        against[-1] -= bundle.k1 / bundle.k1_spread**2
    if bundle.longer is not None:
        zooms = np.arange(6, unknowns - 2, bundle.width)
        stiffness[zooms, zooms] += _ZOOM_SPREAD**-2
        against[zooms] -= bundle.longer / _ZOOM_SPREAD**2
    return stiffness, against, backs


@dataclass(frozen=True, eq=False)
class _Back:
    """How the points (P,) of a group follow from the step of the views that see them, and of the lens."""

    points: IntArray
    columns: IntArray
    """(C,) of the views, the focal length and k1."""
    offset: FloatArray
    """(P, 3)."""
    coupling: FloatArray
    """(P, 3, C)."""


@dataclass(frozen=True, eq=False)
class _Slopes:
    """How N observations change with the unknowns, and what they are off by; all weighted."""

    apart: FloatArray
    """(N, 3): observed minus predicted."""
    by_pose: FloatArray
    """(N, 3, bundle.width) by the step of the observing view."""
    by_lens: FloatArray
    """(N, 3, 2) by the focal length and k1."""
    by_point: FloatArray
    """(N, 3, 3) by the observed point."""


def _slopes(bundle: Bundle, left: FloatArray, group: IntArray) -> _Slopes:
    """Of the observations (N,) of a group."""
    views = bundle.views[group]
    places = local(bundle.poses[views], bundle.points[bundle.seen_points[group]])
    share = np.sqrt(trust((left[group] ** 2).sum(axis=1)))[:, None]
    weights = bundle.seen.weights[group] * share * bundle.enlargement(views)
    change, by_lens = (each * weights[:, :, None] for each in bent_slopes(bundle.lens, places, bundle.k1))
    by_pose = change @ motion_slopes(places)
    if bundle.longer is not None:
        shown = bent(bundle.lens, projected(bundle.lens, places), bundle.k1)
        by_zoom = weights * (shown - (bundle.lens.cx, bundle.lens.cy, 0.0)) * (1, 1, 0)
        by_pose = np.concatenate([by_pose, by_zoom[:, :, None]], axis=2)
    return _Slopes(left[group] * share, by_pose, by_lens, change @ bundle.poses[views][:, :3, :3])


def _eliminate(
    bundle: Bundle,
    left: FloatArray,
    group: IntArray,
    damping: float,
    stiffness: FloatArray,
    against: FloatArray,
) -> _Back:
    """Adds what one group says of views and lens to the equations (U, U) and (U,), its points eliminated."""
    points, of_point = np.unique(bundle.seen_points[group], return_inverse=True)
    views, of_view = np.unique(bundle.views[group], return_inverse=True)
    slopes, width = _slopes(bundle, left, group), bundle.width
    apart, by_pose, by_lens, by_point = slopes.apart, slopes.by_pose, slopes.by_lens, slopes.by_point

    of_points = summed(by_point.swapaxes(1, 2) @ by_point, of_point, len(points))
    pull = summed(along(by_point, apart), of_point, len(points))
    diagonal = np.einsum("ljj->lj", of_points)
    diagonal *= 1 + damping
    diagonal += 1e-9
    inverse = np.linalg.inv(of_points)
    pairs = of_point * len(views) + of_view
    across = summed(by_point.swapaxes(1, 2) @ by_pose, pairs, len(points) * len(views))
    across = across.reshape(len(points), len(views), 3, width).swapaxes(1, 2)
    of_poses = across.reshape(len(points), 3, -1)
    of_lens = summed(by_point.swapaxes(1, 2) @ by_lens, of_point, len(points))
    coupling = np.concatenate([of_poses, of_lens], axis=2)
    solved = inverse @ coupling
    offset = np.einsum("ljk,lk->lj", inverse, pull)

    own_columns = (width * views[:, None] + np.arange(width)).ravel()
    columns = np.r_[own_columns, width * len(bundle.poses) + np.arange(2)]
    own = summed(by_pose.swapaxes(1, 2) @ by_pose, of_view, len(views))
    beside = summed(by_pose.swapaxes(1, 2) @ by_lens, of_view, len(views)).reshape(-1, 2)
    own_diagonal = np.einsum("mjj->mj", own)
    own_diagonal *= 1 + damping
    own_diagonal += 1e-9
    flat, flat_solved = coupling.reshape(-1, len(columns)), solved.reshape(-1, len(columns))
    block = -flat.T @ flat_solved
    for place in range(len(views)):
        here = slice(width * place, width * (place + 1))
        block[here, here] += own[place]
    block[-2:, :-2] += beside.T
    block[:-2, -2:] += beside
    block[-2:, -2:] += np.einsum("nji,njk->ik", by_lens, by_lens) * (1 + damping * np.eye(2))
    stiffness[np.ix_(columns, columns)] += block
    turned = summed(along(by_pose, apart), of_view, len(views))
    said = np.r_[turned.ravel(), along(by_lens, apart).sum(axis=0)]
    against[columns] += said - np.einsum("ljk,lj->k", coupling, offset)
    return _Back(points, columns, offset, solved)


def along(change: FloatArray, values: FloatArray) -> FloatArray:
    """(N, j): slopes (N, 3, j) times values (N, 3), summed over the three."""
    return np.asarray((change * values[:, :, None]).sum(axis=1))


def summed(values: FloatArray, of: IntArray, count: int) -> FloatArray:
    """(count, ...) sums of the values (N, ...) of each; 0 where it has none."""
    order = np.argsort(of, kind="stable")
    starts = np.flatnonzero(np.diff(of[order], prepend=-1))
    sums = np.zeros((count, *values.shape[1:]))
    sums[of[order[starts]]] = np.add.reduceat(values[order], starts, axis=0)
    return sums
