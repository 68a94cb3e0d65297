"""Cameras and points of a clip without depth, up to scale, from features alone: structure from motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import pairwise
from typing import Final

import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.clip import ByteImage, Clip, SparsePoints
from renderer.poses.bundle import FocalGuess
from renderer.poses.distortion import Distortion, distortion_of
from renderer.poses.growing import SEEN_BY, Growing
from renderer.poses.loop_closure import Closed, closed
from renderer.poses.lost_frame import LostFrame
from renderer.poses.outlying_points import outlying
from renderer.poses.parts import MOST_BRIDGED, SHORTEST, Lost, commonest, parts_of, pictures_of
from renderer.poses.pictures import small_lens, trackable
from renderer.poses.rigid_motion import in_unit, local, zoomed
from renderer.poses.search import FoundPoses, PosesError, found_poses
from renderer.poses.settling import Settled, settled
from renderer.poses.starting import started
from renderer.poses.steadying import steadied
from renderer.poses.tracks import Tracked, Tracks
from renderer.poses.triangulation import triangulated
from renderer.poses.views import Rough, View

Tell = Callable[[int, int], None]
Grey = Callable[[int], ByteImage]
MEDIAN_DEPTH: Final = 100.0
"""Scene units, of the points: the scale of what has none."""
FOCAL_SPREAD: Final = 0.25
"""Of the logarithm of a focal length that is guessed: fields of view of 60 degrees may be 45 to 75."""
_CERTAIN = math.radians(1.5)
"""Between rays to a point that a shape begins from."""
_LOOSE = 0.01
"""Of the width, by which such a point may be off, as of tissue that moves."""
_MOST_POINTS = 5000
_MOST_TRIES = 8
_READ_AGAIN = 32
"""Frames that are kept when they have been read again."""
_SAME_FOCAL = 0.01
"""Of its logarithm. On a relief that is seen exactly it still goes 0.03 to 0.05 a try at a third from the
true one."""
_FARTHEST = 0.35
"""Of its logarithm, that a bold try goes beyond where the last one came out of itself."""
_AS_GOOD = 1.01
"""Times the noise of the steadier points, up to which another try counts."""
_TOO_FEW = f"features are followed through fewer than {SHORTEST} frames"


@dataclass(frozen=True, eq=False)
class FoundStructure:
    """The longest part of a clip that holds, in scene units."""

    poses: FoundPoses
    """Its cameras have the focal length that was found."""
    points: SparsePoints
    depth_error: float
    """See Solved."""
    focal_left: float = 0.0
    """See Solved."""
    distortion: Distortion | None = None
    """That the motion shows, where the focal length is not known either; poses and points are without it."""


@dataclass(frozen=True, eq=False)
class FollowedFeatures:
    """What frames show, before anything is known of where it is."""

    parts: tuple[Tracked, ...]
    lost: tuple[LostFrame, ...]
    """Frames in none of them."""


def followed_features(clip: Clip, tell: Tell = lambda done, total: None) -> FollowedFeatures:
    """Of a clip whose one camera is of all frames; `tell` is called with how many are done. Raises ClipError:
    a frame cannot be read."""
    lens = small_lens(clip.cameras[0])
    bare = replace(clip, read_frame=lambda index: replace(clip.read_frame(index), depth=None))
    parts, lost = parts_of(pictures_of(bare, lens, 1.0, tell), Tracks)
    return FollowedFeatures(tuple(part.tracked for part in parts), tuple(lost))


def structure_of(
    clip: Clip, features: FollowedFeatures, *, focal_is_known: bool, tell: Tell = lambda done, total: None
) -> FoundStructure:
    """What the features of a clip show.

    The world is the first camera of the part; the median depth of points is MEDIAN_DEPTH. A focal length
    that is not known is sought along with the rest. `tell` is called with how many keyframes are placed, of
    twice as many: placing what lies between them and bringing all to agree takes about as long.

    Raises:
        PosesError: no part of SHORTEST frames tells distances, and why.
        ClipError: a frame that shows a place again cannot be read.
    """
    lens = small_lens(clip.cameras[0])
    focal = None if focal_is_known else FocalGuess(lens.fx, FOCAL_SPREAD)
    try:
        found = focused(lens, features.parts, focal, tell, _greys(clip, lens))
    except Lost as reason:
        said = str(reason) if features.parts else commonest([each.why for each in features.lost], _TOO_FEW)
        raise PosesError(said) from reason
    each_lost = {each.frame: each for each in (*features.lost, *found.lost)}
    lost = [each_lost[frame] for frame in sorted(each_lost)]
    poses = replace(found_poses(clip, found.done, 1.0, lost), closed=found.closed)
    bending = None if focal is None else distortion_of(found.done, features.parts, focal)
    return FoundStructure(poses, SparsePoints(found.points), found.depth_error, found.focal_left, bending)


def _greys(clip: Clip, lens: Camera) -> Grey:
    """Frames as their features were followed in them."""
    size = lens.width, lens.height
    return lru_cache(_READ_AGAIN)(lambda frame: trackable(clip.read_frame(frame), size)[0])


@dataclass(frozen=True, eq=False)
class Solved:
    """Views in scene units, and what they show."""

    done: Settled
    points: FloatArray
    """(P, 3) in the axes of the first view, of tissue that moves as well."""
    depth_error: float
    """Of points in the median, as a share of their depth, by how far they are from where they are seen; a
    focal length that is wrong, or tissue that moves along, comes on top."""
    lost: list[LostFrame]
    """Without a pose although features were followed."""
    focal_left: float = 0.0
    """Share by which the focal length still changed when its search ended; 0: it is known, or settled."""
    closed: tuple[tuple[int, int], ...] = ()
    """See FoundPoses."""


def focused(
    lens: Camera,
    parts: Sequence[Tracked],
    focal: FocalGuess | None,
    tell: Tell,
    grey: Grey | None = None,
) -> Solved:
    """As `solved`, and where the focal length that comes out is not the one it began with, again from others:
    a shape that is grown by a wrong one gives up a small part of its error alone. They reach ever farther the
    way the focal length went, and then between those that it came from on either side. A try that holds fewer
    frames, or agrees clearly less, does not count; a second one ends it. Raises Lost: the first finds
    nothing, and why."""
    best = _Try(0.0, solved(lens, parts, focal, tell, grey), lens)
    if focal is None:
        return best.solved
    tries, seen, bold = [best], [best], True
    for number in range(1, _MOST_TRIES):
        if abs(best.step) < _SAME_FOCAL:
            break
        zoom = _next(best, tries, bold=bold)
        begun = zoomed(lens, zoom)
        try:
            again = _Try(zoom, solved(begun, parts, focal, partial(_told_later, tell, number), grey), lens)
            seen.append(again)
        except Lost:
            again = None
        if again is not None and again.is_as_good(best):
            best = again
            tries.append(again)
        elif zoom != _next(best, tries, bold=False):
            bold = False
        else:
            break
    return replace(best.solved, focal_left=_left(best, seen))


@dataclass(frozen=True, eq=False)
class _Try:
    """A shape that was grown by one focal length."""

    zoom: float
    """Logarithm of that, in those of the lens that was guessed."""
    solved: Solved
    guessed: Camera

    @property
    def end(self) -> float:
        """Of the focal length that came out."""
        return math.log(self.solved.done.lens.fx / self.guessed.fx)

    @property
    def step(self) -> float:
        """How far the focal length went."""
        return self.end - self.zoom

    def is_as_good(self, other: _Try) -> bool:
        mine, theirs = self.solved.done, other.solved.done
        as_many = len(mine.views) >= len(theirs.views)
        return as_many and mine.noise.pixel <= _AS_GOOD * theirs.noise.pixel


def _left(best: _Try, seen: Sequence[_Try]) -> float:
    """How far the best is from where a try stayed; 0 for no more than _SAME_FOCAL. One that agrees less, and
    does not count otherwise, tells that as well."""
    stayed = [abs(best.end - each.end) for each in seen if abs(each.step) < _SAME_FOCAL]
    left = min([abs(best.step), *stayed])
    return left if left >= _SAME_FOCAL else 0.0


def _next(best: _Try, tries: Sequence[_Try], *, bold: bool) -> float:
    """Where to grow the next shape: between two from which the focal length goes towards each other, else
    the way it went, farther with each try that is `bold`."""
    way = math.copysign(1.0, best.step)
    others = [each for each in tries if way * (each.zoom - best.zoom) > 0 and way * each.step < 0]
    if others:
        other = min(others, key=lambda each: abs(each.zoom - best.zoom))
        return best.zoom + (other.zoom - best.zoom) * best.step / (best.step - other.step)
    reach = min(abs(best.step) * 2 ** (len(tries) - 1), _FARTHEST) if bold else 0.0
    return best.zoom + way * max(reach, abs(best.step))


def _told_later(tell: Tell, tries: int, done: int, total: int) -> None:
    """Each try takes half of what the ones before have left of the whole."""
    tell(total * (2**tries - 1) + done, total * 2**tries)


def solved(
    lens: Camera,
    parts: Sequence[Tracked],
    focal: FocalGuess | None,
    tell: Tell = lambda done, total: None,
    grey: Grey | None = None,
) -> Solved:
    """The longest part that holds; where `grey` gives its frames, its path is closed (loop_closure.py).

    Raises Lost: no part of SHORTEST frames tells distances, and why.
    """
    best: tuple[Rough, Closed] | None = None
    waiting, lost, why = list(parts), list[LostFrame](), list[str]()
    while waiting:
        waiting.sort(key=lambda part: len(part.sights))
        part = waiting.pop()
        if len(part.sights) < SHORTEST or (best is not None and len(part.sights) <= len(best[0].views)):
            break
        try:
            growing = started(lens, part, focal)
            ended = growing.grow(tell)
            growing = steadied(growing)
        except Lost as reason:
            why.append(str(reason))
            continue
        loop = Closed(growing, part) if grey is None else closed(growing, part, grey)
        rough, left = _all_views(loop.growing, loop.part, focal)
        lost += [LostFrame(part.sights[part.keys[key]].frame, said) for key, said in ended.items()] + left
        if best is None or len(rough.views) > len(best[0].views):
            best = rough, loop
        waiting += _rest(part, growing)
    if best is None or len(best[0].views) < SHORTEST:
        raise Lost(commonest([*why, *(each.why for each in lost)], _TOO_FEW))
    rough, loop = best
    held = {view.frame for view in rough.views}
    shown = tuple(pair for pair in loop.frames if held.issuperset(pair))
    return Solved(*_shaped(settled(rough), rough.keys, loop.part), lost, closed=shown)


def _rest(part: Tracked, growing: Growing) -> Iterator[Tracked]:
    """What of a part holds on to nothing that has grown."""
    first, last = min(growing.poses), max(growing.poses)
    if first > 0:
        yield part.between(0, first - 1)
    if last + 1 < len(part.keys):
        yield part.between(last + 1, len(part.keys) - 1)


def _all_views(growing: Growing, part: Tracked, focal: FocalGuess | None) -> tuple[Rough, list[LostFrame]]:
    """Of the frames between the keyframes that have grown, and those behind the last of all."""
    first, last = min(growing.poses), max(growing.poses)
    held = part.between(first, last)
    keyed = {key: growing.poses[first + number] for number, key in enumerate(held.keys)
             if first + number in growing.poses}  # fmt: skip
    if last + 1 < len(part.keys):
        held = replace(held, sights=held.sights[: held.keys[-1] + 1])
    compact = np.full(len(growing.points), -1)
    compact[growing.known] = np.arange(len(growing.known))
    views, keys, lost, at = list[View](), list[int](), list[LostFrame](), list[int]()
    pose: FloatArray = growing.poses[first]
    for place, sight in enumerate(held.sights):
        ids, seen = growing.seen_by(sight)
        try:
            if place in keyed:
                growing.require(ids)
                keys.append(len(views))
                pose, inliers = keyed[place], np.ones(len(ids), bool)
            else:
                found = growing.placed(sight, pose)
                pose, inliers = found.pose, found.inliers
        except Lost as reason:
            lost.append(LostFrame(sight.frame, str(reason)))
            continue
        views.append(View(sight.frame, pose, compact[ids], seen, inliers))
        at.append(place)
    rough = Rough(growing.lens, tuple(views), tuple(keys), growing.points[growing.known], focal)
    return _unbroken(rough, at), lost


def _unbroken(rough: Rough, places: Sequence[int]) -> Rough:
    """The longest run of views without a gap that is too wide to go on behind; it begins with a keyframe.
    `places` are theirs among the frames that features were followed through."""
    gaps = [at + 1 for at, (one, two) in enumerate(pairwise(places)) if two - one > MOST_BRIDGED + 1]
    runs = list(pairwise([0, *gaps, len(places)]))
    start, end = max(runs, key=lambda run: run[1] - run[0])
    start = min(key for key in (*rough.keys, end) if key >= start)
    keys = tuple(key - start for key in rough.keys if start <= key < end)
    return replace(rough, views=rough.views[start:end], keys=keys)


def _shaped(done: Settled, keys: tuple[int, ...], part: Tracked) -> tuple[Settled, FloatArray, float]:
    """The same in scene units, all points (P, 3) that keyframes tell the distance of, and how well points
    that are seen often are told, see Solved."""
    sights = {sight.frame: sight for sight in part.sights}
    shown = [sights[done.views[key].frame] for key in keys]
    ids, places = (np.concatenate([getattr(sight, name) for sight in shown]) for name in ("ids", "places"))
    each = np.stack([done.views[key].pose for key in keys])
    poses = np.repeat(each, [len(sight.ids) for sight in shown], axis=0)
    found = triangulated(done.lens, poses, ids, places, part.count)
    often = np.bincount(ids, minlength=part.count) >= min(SEEN_BY, len(keys))
    close = often & (found.misfit < _LOOSE * done.lens.width)
    error = float(np.median(found.depth_error(done.lens)[close])) if close.any() else math.inf
    good = close & (found.angle > _CERTAIN)
    if not good.any():
        good = often & np.isfinite(found.misfit)
    factor = MEDIAN_DEPTH / float(np.median(local(poses, found.where[ids])[good[ids], 2]))
    views = tuple(replace(view, pose=in_unit(view.pose, factor)) for view in done.views)
    points = factor * found.where[good]
    points = points[:: -(-len(points) // _MOST_POINTS)]
    points = points[~outlying(done.lens, np.stack([views[key].pose for key in keys]), points)]
    return replace(done, views=views, points=factor * done.points), local(views[0].pose, points), error
