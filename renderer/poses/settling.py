"""All views of a part and all its points brought to agree, by how well each of them fits."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from renderer.camera import Camera, FloatArray, IntArray
from renderer.poses.bundle import adjusted
from renderer.poses.resection import TO_DEVIATION, agreeing, resected, trust
from renderer.poses.rigid_motion import Seen, local, projected
from renderer.poses.tissue_motion import places_of, poses_by_motion
from renderer.poses.told_apart import TissueMotion
from renderer.poses.views import DEPTH_NOISE, Rough, View, bundle_of

_PASSES = 4
_WITHOUT_DEPTH = 2
"""Passes: keyframes and points have been adjusted before."""
_FIRST_PX = 2.0
"""px: as if the tissue deformed by that, before it is known."""
_SLACK = 5.0
"""By which places in the picture count less than their misfit allows, of tissue that deforms. Poses and shape
together can take up much of a deformation in the picture, and little of it in depth, which must keep a say.
On a phantom that is pulled in a third of the view, depth off by 0.3 px of disparity, 1 leaves 6.6 % of the
path as error, 5 leaves 2.8 %."""
_RIGID_SLACK = 1.0
"""Of tissue that does not: on a phantom at rest 1 leaves 0.12 %, 5 leaves 0.19 %."""
_TAKEN_UP = 1.2
"""Times the misfit in depth: where it is more, a fit to the places alone takes up a deformation. Of two
phantoms at rest and a sinus it is 0.9 to 1.1, of four that deform 1.3 to 3.4."""
_OFF = 0.3
"""Pixels by which places are off where all tissue may move together, or too little of it for the depth of
most to tell: 0.1 to 0.3 of phantoms at rest, 0.4 of one whose pull the depth misses, 0.7 of those that
breathe."""
_SHARES = (0.35, 0.25, 0.2, 0.15, 0.12, 0.1, 0.08, 0.065)
"""Of the points, those that move least; only where tissue deforms, after the steadier half. Of a phantom that
is pulled, the last four take the error from 1.17 to 0.77 % of the path of 60 frames, from 1.26 to 0.90 % of
600, and from 1.71 to 1.60 % where depth is off by 0.3 px. Larger steps are held by tissue that moves little:
where the eight leave 0.64 % of one whose features are simulated, five down to as few leave 1.09 %. Where all
tissue breathes, 8 to 10 % stay with any of them: what it does as a whole counts as the camera's motion."""
_FEWEST_DECIDING = 60
"""Points: fewer may lie in one corner of the view, and agree by chance."""
_NARROWING = 3
"""Passes with each of these shares; 1 leaves 1.28 % of the first error."""
_BY_DEPTH = 10.0
"""As _SLACK, of these shares, where depth is off: 3 leaves 3.14 %, 5 leaves 2.07 %, 8 to 20 leave 1.5 %."""
_AGREEING = 1.3
"""By how much the misfit of these points in the picture may grow. On phantoms that deform it is 0.6 to 1.1
times as large then; on a real wall, whose depth is from eyes without calibration, 1.8 times, and test frames
fit worse (31.9 for 34.1 dB)."""
_SEEN_ENOUGH = 3
"""Views of a point from which on its misfit says whether it moves."""
_STRAY = 4 / 3
"""Of OUTLYING ones: a point that is off by four standard deviations in half of its views counts a quarter."""
_LEAST = 1e-3
"""Of a weight: equations stay solvable for points that count for nothing."""
_LEAST_PX, _LEAST_DEPTH = 0.02, 1e-5


@dataclass(frozen=True)
class Noise:
    """Standard deviations as measured from what is left over."""

    pixel: float
    """px."""
    depth: float
    """Of the inverse depth at the typical distance."""

    def beside(self, pixel: float, lens: Camera) -> Noise:
        """Of tissue that deforms by `pixel` px in the picture, and by as much along the view."""
        return Noise(pixel, math.hypot(self.depth, pixel / lens.fx))


@dataclass(frozen=True, eq=False)
class Settled:
    """Views that agree with each other, in the order of their frames."""

    lens: Camera
    views: tuple[View, ...]
    points: FloatArray
    """(L, 3) in world coordinates, the axes of the first view."""
    noise: Noise
    tissue: TissueMotion = "not sought"


def settled(rough: Rough) -> Settled:
    """Keyframes and points are adjusted together, then the other views to the points; four times.

    Noise is measured on the steadier half of the points. Points that stray from where they should
    be, over all views, count for little: they are on tissue that moves, or on a tool. First as if the
    tissue deformed; where it turns out not to, or without depth, which alone would tell, by places in the
    picture, which are the more exact. Where it does deform, it is sought how: tissue_motion.py;
    and where that is in no few ways, those that move least decide at last.
    """
    lens, views, points = rough.lens, rough.views, rough.points
    start = Settled(lens, views, points, _judged(lens, points, views)[0])
    if not any((view.seen.weights[:, 2] > 0).any() for view in views):
        return _settled(rough, start, _RIGID_SLACK, _WITHOUT_DEPTH)
    soft = _settled(rough, start, _SLACK, first=_FIRST_PX)
    rigid = _settled(rough, soft, _RIGID_SLACK)
    deforms = rigid.noise.depth >= _TAKEN_UP * soft.noise.depth
    if not deforms and rigid.noise.pixel <= _OFF:
        return rigid
    if (by_motion := _by_motion(soft)) is not None:
        return by_motion
    return replace(_by_the_steadiest(rough, soft) if deforms else rigid, tissue="not found")


def _by_motion(soft: Settled) -> Settled | None:
    """As if all tissue moved in a few ways; None where it does not."""
    poses = poses_by_motion(soft.lens, soft.views, soft.points)
    if poses is None:
        return None
    views = tuple(replace(view, pose=pose) for view, pose in zip(soft.views, poses, strict=True))
    points = places_of(soft.lens, views, soft.points)
    noise, steady = _judged(soft.lens, points, views)
    return Settled(
        soft.lens, tuple(_agreeing(soft.lens, points, view, noise, steady) for view in views), points, noise,
        "found",
    )  # fmt: skip


def _by_the_steadiest(rough: Rough, soft: Settled) -> Settled:
    """An ever smaller share of the points decides, those that move least: the camera moves against these.

    Keyframes are adjusted first, then the other views to their points. Where any of these come to agree less,
    the depth is wrong rather than the tissue in motion, and all stays as it was.
    """
    shares = [share for share in _SHARES if share * len(soft.points) >= _FEWEST_DECIDING]
    if not shares:
        return soft
    keyframes = tuple(soft.views[key] for key in rough.keys)
    alone = replace(rough, views=keyframes, keys=tuple(range(len(keyframes))))
    done = replace(soft, views=keyframes)
    for share in shares:
        done = _settled(alone, done, _BY_DEPTH, _NARROWING, share)
        before, _ = _judged(soft.lens, soft.points, keyframes, share)
        if done.noise.pixel > _AGREEING * before.pixel:
            return soft
    noise, steady = _judged(done.lens, done.points, done.views, shares[-1])
    weighing = noise.beside(_BY_DEPTH * noise.pixel, done.lens)
    starts = _carried(rough.keys, soft.views, np.stack([view.pose for view in done.views]))
    views = (replace(view, pose=start) for view, start in zip(soft.views, starts, strict=True))
    weighed = (_weighed(done.lens, done.points, view, weighing, steady) for view in views)
    return replace(done, views=tuple(_again(done.lens, done.points, view, view.pose) for view in weighed))


def _settled(
    rough: Rough,
    start: Settled,
    slack: float,
    passes: int = _PASSES,
    share: float = 0.5,
    first: float | None = None,
) -> Settled:
    """From views and points that nearly fit; places count as if they were off by `slack` times the noise of
    the steadiest `share` of the points, to begin with by `first` px if that is given."""
    lens, views, points = start.lens, start.views, start.points
    noise, steady = _judged(lens, points, views, share)
    weighing = noise.beside(slack * noise.pixel if first is None else first, lens)
    for _ in range(passes):
        views = tuple(_weighed(lens, points, view, weighing, steady) for view in views)
        keys = [views[place] for place in rough.keys]
        bundle = adjusted(bundle_of(lens, keys, points, rough.focal))
        starts = _carried(rough.keys, views, bundle.poses)
        lens, points = bundle.lens, bundle.points
        views = tuple(_again(lens, points, *each) for each in zip(views, starts, strict=True))
        noise, steady = _judged(lens, points, views, share)
        weighing = noise.beside(slack * noise.pixel, lens)
    return Settled(lens, views, points, noise)


def apart(lens: Camera, points: FloatArray, view: View) -> FloatArray:
    """(N, 3) measured minus expected: px, px, inverse depth; meaningless where that is not measured."""
    return np.asarray(view.seen.measured - projected(lens, local(view.pose, points[view.ids])))


def _judged(
    lens: Camera, points: FloatArray, views: tuple[View, ...], share: float = 0.5
) -> tuple[Noise, FloatArray]:
    """The noise of the steadiest `share` of the points, and (L,) in [0, 1] how much each counts."""
    ids = np.concatenate([view.ids for view in views])
    off = np.concatenate([apart(lens, points, view) for view in views])
    known = np.concatenate([view.seen.weights[:, 2] > 0 for view in views])
    often = np.bincount(ids, minlength=len(points)) >= _SEEN_ENOUGH
    noise, stray = Noise(1.0, DEPTH_NOISE), np.linalg.norm(off[:, :2], axis=1)
    for _ in range(2):
        per_point = _medians(stray, ids, len(points))
        most = float(np.quantile(per_point[often], share)) if often.any() else math.inf
        still = ((per_point <= most) & (often | math.isinf(most)))[ids]
        pixel, depth = _spread(off[still, :2]), _spread(off[still & known, 2])
        noise = Noise(max(pixel, _LEAST_PX), max(depth, _LEAST_DEPTH))
        left = off / (noise.pixel, noise.pixel, noise.depth)
        left[~known, 2] = 0
        stray = np.linalg.norm(left, axis=1)
    return noise, trust((_medians(stray, ids, len(points)) / _STRAY) ** 2)


def _spread(values: FloatArray) -> float:
    """Standard deviation of most of the values; 0 of none."""
    return TO_DEVIATION * float(np.median(np.abs(values))) if values.size else 0.0


def _medians(values: FloatArray, of: IntArray, count: int) -> FloatArray:
    """(count,) of the values (N,) of each; 0 where it has none."""
    order = np.lexsort((values, of))
    bounds = np.searchsorted(of[order], np.arange(count + 1))
    middle = np.minimum((bounds[:-1] + bounds[1:]) // 2, len(values) - 1)
    return np.where(bounds[1:] > bounds[:-1], values[order][middle], 0.0)


def _weighed(lens: Camera, points: FloatArray, view: View, noise: Noise, steady: FloatArray) -> View:
    """The depth of a view may be worse than of most, as that of eyes that do not look at the same moment."""
    known = view.seen.weights[:, 2] > 0
    depth = max(noise.depth, _spread(apart(lens, points, view)[known, 2]))
    each = 1 / np.array([noise.pixel, noise.pixel, depth])
    counts = np.maximum(np.sqrt(steady[view.ids]), _LEAST)[:, None]
    return replace(view, seen=Seen(view.seen.measured, np.where(view.seen.weights > 0, each * counts, 0.0)))


def _carried(keys: tuple[int, ...], views: tuple[View, ...], poses: FloatArray) -> list[FloatArray]:
    """Where the views are when each moves along with the keyframe before it.

    By the inverse itself: a transposed turn would triple its error of rounding in each pass.
    """
    numbers = np.searchsorted(keys, np.arange(len(views)), side="right") - 1
    backs = [np.linalg.inv(views[key].pose) @ pose for key, pose in zip(keys, poses, strict=True)]
    return [view.pose @ backs[number] for view, number in zip(views, numbers, strict=True)]


def _agreeing(lens: Camera, points: FloatArray, view: View, noise: Noise, steady: FloatArray) -> View:
    """With the points that agree with its pose."""
    weighed = _weighed(lens, points, view, noise.beside(_SLACK * noise.pixel, lens), steady)
    return replace(weighed, inliers=agreeing(lens, points[view.ids], weighed.seen, view.pose).inliers)


def _again(lens: Camera, points: FloatArray, view: View, start: FloatArray) -> View:
    found = resected(lens, points[view.ids], view.seen, [start])
    return replace(view, pose=found.pose, inliers=found.inliers)
