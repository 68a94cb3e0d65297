"""Poses of a camera before tissue that moves in a few ways: as if all of it breathed, or were pulled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from renderer.camera import Camera, FloatArray, IntArray
from renderer.evenly import evenly
from renderer.poses.alike import by_size, left_by_neighbours, shared_motions, told_by_depth
from renderer.poses.between import between
from renderer.poses.bundle import summed
from renderer.poses.deforming import Deforming, fitted
from renderer.poses.resection import TO_DEVIATION
from renderer.poses.rigid_motion import Seen, lifted
from renderer.poses.rigid_share import by_speed, divided, fast_motions
from renderer.poses.views import View

_MOTIONS = 2
"""Breathing and a pull."""
_APART = 5
"""Frames, about, of those by which motions are found; breathing takes more."""
_LEAST_LOOKED_AT, _MOST_LOOKED_AT = 60, 120
"""Of these frames: time grows with the square of their number."""
_FEWEST = 20
"""Frames: fewer tell no time course of a motion."""
_MOST_POINTS = 1000
_FEWEST_POINTS = 60
_OFTEN = 0.1
"""Share of these frames that show a point whose motion is sought."""
_STAGES, _SLOW_STAGES, _ROUNDS = 4, 2, 6
"""In each stage the weights follow what is left over; there are more where all motions are slow and
depth is not exact."""
_DIVISIONS, _BETWEEN = 2, 8
_AT_ALL = 10
"""Rounds for the frames between."""
_SLACK = 1.5
"""By which places and depth count less than their noise, for motions that are not those few."""
_SLOW_SLACK = 5.0
"""Of places there, as in settling.py: a track drifts along the tissue for many frames,
which together tell little more of its place than one, whereas errors of depth are each frame's own. Of six
phantoms of 600 frames that are pulled, depth off by 0.3 px, 0.25 to 0.39 % of the path is left as error with
the motions that points share, 0.27 to 1.02 % with two and _SLACK."""
_LEFT = 0.25
"""Of what is left over in the image where points are at rest: where more is left, tissue does not move so. Of
phantoms that breathe or are pulled 0.08 to 0.16 is left (seeds 0 and 2), of a real wall, whose depth is from
eyes without calibration, 0.34."""
_BY_NEIGHBOURS = 0.6
"""Of what is left over where tissue moves as one rigid body: of those phantoms 0.15 to 0.43 is left where
points move as those around them, of one at rest 0.77, and 0.83 where its depth is off by 0.3 px."""
_LEAST_PX, _LEAST_DEPTH = 0.02, 1e-5


def poses_by_motion(lens: Camera, views: Sequence[View], points: FloatArray) -> list[FloatArray] | None:
    """One pose (4, 4) a view, from poses and points (L, 3) that nearly fit; None where the tissue does not
    move in so few ways, or in too few frames to tell."""
    if len(views) < _FEWEST:
        return None
    looked_at = evenly(range(len(views)), min(max(len(views) // _APART, _LEAST_LOOKED_AT), _MOST_LOOKED_AT))
    ids = _chosen([views[place] for place in looked_at], len(points))
    if len(ids) < _FEWEST_POINTS:
        return None
    still = _still(lens, [views[place] for place in looked_at], points, ids)
    now = _begun(still)
    for _ in range(_STAGES):
        now = fitted(_weighed(now), _ROUNDS)
    if _noise(now)[0] > _LEFT * _noise(still)[0] or left_by_neighbours(now) > _BY_NEIGHBOURS:
        return None
    sized = by_size(now)
    if not told_by_depth(sized) and not fast_motions(by_speed(now)):
        now = shared_motions(sized)
        for _ in range(_SLOW_STAGES):
            now = fitted(_weighed(now, _SLOW_SLACK), _ROUNDS)
    for _ in range(_DIVISIONS):
        now = fitted(divided(now), _BETWEEN)
    return _of_all(divided(now), looked_at, views, ids)


def _chosen(views: Sequence[View], count: int) -> IntArray:
    """Of `count` points, those seen in the most of the views."""
    often = np.bincount(np.concatenate([view.ids for view in views]), minlength=count)
    order = np.argsort(-often, kind="stable")[:_MOST_POINTS]
    return np.sort(order[often[order] >= max(2 * _MOTIONS, _OFTEN * len(views))])


def _still(lens: Camera, views: Sequence[View], points: FloatArray, ids: IntArray) -> Deforming:
    """As if the points chosen were at rest."""
    frames, of, seen = _observed(views, ids, len(points))
    none = np.zeros((len(ids), _MOTIONS, 3))
    return Deforming(
        lens=lens, poses=np.stack([view.pose for view in views]), courses=np.zeros((len(views), _MOTIONS)),
        rest=points[ids], shifts=none, held_to=none, frames=frames, points=of, seen=seen,
    )  # fmt: skip


def _begun(still: Deforming) -> Deforming:
    """With time courses of what is left over (principal components)."""
    seen, frames, of = still.seen, still.frames, still.points
    courses = _common(still)
    known = seen.weights[:, 2] > 0
    at = still.poses[frames[known]]
    places = lifted(still.lens, seen.measured[known])
    moved = np.zeros((len(still.poses), len(still.rest), 3))
    moved[frames[known], of[known]] = np.einsum("nji,nj->ni", at[:, :3, :3], places - at[:, :3, 3])
    moved[frames[known], of[known]] -= still.rest[of[known]]
    shown = np.zeros(moved.shape[:2])
    shown[frames, of] = 1
    of_points = np.einsum("fp,fk,fl->pkl", shown, courses, courses) + _MOTIONS * np.eye(_MOTIONS)
    shifts = np.linalg.solve(of_points, np.einsum("fk,fpi->pki", courses, moved))
    return replace(still, courses=courses, shifts=shifts)


def _common(still: Deforming) -> FloatArray:
    """(F, K) time courses that what is left over has most in common, about its mean of each point: in units
    of its noise, as depth may be far less exact than places, and of what the point strays, so that no few
    points that are followed wrongly decide."""
    weighed = _weighed(still)
    shape = len(still.poses), len(still.rest)
    left, shown = np.zeros((*shape, 3)), np.zeros(shape)
    left[still.frames, still.points] = weighed.apart() * weighed.seen.weights
    shown[still.frames, still.points] = 1
    often = np.maximum(shown.sum(axis=0), 1)
    left -= shown[:, :, None] * (left.sum(axis=0) / often[:, None])
    sizes = (left**2).sum(axis=(0, 2)) / often
    flat = (left / np.sqrt(sizes + np.median(sizes) + 1e-12)[:, None]).reshape(len(left), -1)
    alike = (flat @ flat.T) / np.maximum(shown @ shown.T, 1)
    return np.asarray(np.linalg.eigh(alike)[1][:, : -_MOTIONS - 1 : -1] * np.sqrt(len(left)))


def _observed(views: Sequence[View], ids: IntArray, count: int) -> tuple[IntArray, IntArray, Seen]:
    """Which view, which of the points chosen, and what was measured, of all that the views show of these."""
    place = np.full(count, -1)
    place[ids] = np.arange(len(ids))
    of = place[np.concatenate([view.ids for view in views])]
    frames = np.repeat(np.arange(len(views)), [len(view.ids) for view in views])
    measured, weights = (
        np.concatenate([getattr(view.seen, name) for view in views]) for name in ("measured", "weights")
    )
    held = of >= 0
    return frames[held], of[held], Seen(measured[held], weights[held])


def _noise(now: Deforming) -> tuple[float, float]:
    """Standard deviation of most places, in px, and inverse depths."""
    off = np.abs(now.apart())
    known = now.seen.weights[:, 2] > 0
    pixel, depth = (float(np.median(each)) if each.size else 0.0 for each in (off[:, :2], off[known, 2]))
    return max(TO_DEVIATION * pixel, _LEAST_PX), max(TO_DEVIATION * depth, _LEAST_DEPTH)


def _weighed(now: Deforming, slack: float = _SLACK) -> Deforming:
    pixel, depth = _noise(now)
    each = 1 / np.array([slack * pixel, slack * pixel, _SLACK * depth])
    return replace(now, seen=Seen(now.seen.measured, np.where(now.seen.weights > 0, each, 0.0)))


def _of_all(
    found: Deforming, looked_at: Sequence[int], views: Sequence[View], ids: IntArray
) -> list[FloatArray]:
    """Poses of all views by points and motions that were found in some of them."""
    frames, of, seen = _observed(views, ids, int(max(view.ids.max() for view in views)) + 1)
    known = dict(zip(looked_at, found.poses, strict=True))
    poses = np.stack([known[at] if at in known else between(known, at) for at in range(len(views))])
    courses = [np.interp(np.arange(len(views)), looked_at, course) for course in found.courses.T]
    start = replace(
        found, poses=poses, courses=np.stack(courses, axis=1), frames=frames, points=of, seen=seen,
    )  # fmt: skip
    return list(fitted(_weighed(start), _AT_ALL, points_stay=True).poses)


def places_of(lens: Camera, views: Sequence[View], points: FloatArray) -> FloatArray:
    """(L, 3) where the views saw each point in the mean; as in `points` (L, 3) where its depth is not
    measured."""
    held = [view.seen.weights[:, 2] > 0 for view in views]
    ids = np.concatenate([view.ids[which] for view, which in zip(views, held, strict=True)])
    there = [
        (lifted(lens, view.seen.measured[which]) - view.pose[:3, 3]) @ view.pose[:3, :3]
        for view, which in zip(views, held, strict=True)
    ]
    count = np.bincount(ids, minlength=len(points))
    total = summed(np.concatenate(there), ids, len(points))
    return np.where(count[:, None] > 0, total / np.maximum(count, 1)[:, None], points)
