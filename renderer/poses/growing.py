"""Keyframes placed one after another by points that those before them have shown: structure from motion.

Begun by two views (two_views.py) and grown by resection, triangulation and bundle adjustment in turn, as
Schoenberger and Frahm, "Structure-from-motion revisited", 2016, describe it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence, Set
from copy import copy
from dataclasses import replace
from typing import Final

import numpy as np

from renderer.camera import Camera, FloatArray, IntArray
from renderer.poses.bundle import Bundle, FocalGuess, adjusted, misfit
from renderer.poses.parts import Lost
from renderer.poses.resection import FEWEST, OUTLYING, Resected, by_chance, resected
from renderer.poses.rigid_motion import Seen, local, projected
from renderer.poses.similarity import Similarity
from renderer.poses.tracks import Sight, Tracked
from renderer.poses.triangulation import Triangulated, judged, triangulated
from renderer.poses.views import PIXEL_NOISE

NARROWEST: Final = math.radians(1.0)
"""Between rays to a point: where they are more alike, its distance is not certain."""
MOST_MISFIT: Final = 0.008
"""Of the width: half of the points of a frame that moved by more on their own leave it without a pose."""
SEEN_BY: Final = 3
"""Keyframes that tell whether a track agrees with them: two always nearly do."""
_FIRST_PX, _LEAST_PX = 1.0, 0.1
"""px, noise of places before it is measured, and the least."""
_CLOSING_PX = (2.0, 0.7)
"""The noise while a path is closed."""
_STRAY = 4.0
"""Times the noise: points that are farther off, over all views, are not of the body that is followed."""
_ROUNDS = 6
"""Of bundle adjustment each time: it goes on with the next keyframe."""
_GROWN = 1.15
"""Times as many keyframes: all are adjusted anew."""
_FREE_FROM = 5
"""Keyframes from which on a focal length is sought."""
_TO_DEVIATION = 0.8493
"""From the median length of two normally distributed numbers to the standard deviation of each."""


class Growing:
    """Poses of keyframes and points of tracks, as far as they are known."""

    def __init__(self, lens: Camera, tracks: Tracked, focal: FocalGuess | None) -> None:
        self.lens = lens
        self.poses: dict[int, FloatArray] = {}
        """Of keyframes, by their number: (4, 4), camera from world."""
        self.points = np.full((tracks.count, 3), np.nan)
        """NaN where not known."""
        self.noise = _FIRST_PX
        """px."""
        self._sights = [tracks.sights[place] for place in tracks.keys]
        self._focal, self._adjusted_at = focal, 0

    @property
    def known(self) -> IntArray:
        return np.flatnonzero(np.isfinite(self.points[:, 0]))

    def begin(self, first: int, second: int, pose: FloatArray) -> None:
        """From two keyframes, the second at `pose` (4, 4) in the axes of the first. Raises Lost."""
        self.poses = {first: np.eye(4), second: pose}
        self.points[:] = np.nan
        self.noise = _FIRST_PX
        self._triangulate(2 * OUTLYING * _FIRST_PX)
        self.adjust()

    def grow(self, tell: Callable[[int, int], None]) -> dict[int, str]:
        """Takes in every keyframe that holds on to those before it; of the two at which it ends on either
        side, if any, why. `tell` is called with how many are done, of twice as many."""
        ended: dict[int, str] = {}
        while open_ends := self._next(ended.keys()):
            tell(len(self.poses), 2 * len(self._sights))
            number = max(open_ends, key=self._shown)
            try:
                self.poses[number] = self.placed(self._sights[number], self._nearest(number)).pose
            except Lost as reason:
                ended[number] = str(reason)
                continue
            self._triangulate(OUTLYING * self.noise * 2)
            if len(self.poses) < 2 * _FREE_FROM or len(self.poses) >= _GROWN * self._adjusted_at:
                self.adjust()
        self.adjust()
        self._triangulate(OUTLYING * self.noise * 2)
        self.adjust()
        return ended

    def moved_to(self, tracks: Tracked, moves: Sequence[Similarity]) -> Growing:
        """Each keyframe moved along with the points that it is the first to show, and all adjusted to tracks
        of which keyframes show more than before. Raises Lost."""
        other, numbers = copy(self), sorted(self.poses)
        first = np.full(len(self.points), -1)
        for place in reversed(range(len(numbers))):
            first[self._sights[numbers[place]].ids] = place
        other.points = self.points.copy()
        other.poses = {}
        for place, (number, move) in enumerate(zip(numbers, moves, strict=True)):
            other.poses[number] = move.carried(self.poses[number])
            other.points[first == place] = move(self.points[first == place])
        other._sights = [tracks.sights[place] for place in tracks.keys]
        for noise in _CLOSING_PX:
            other.noise = noise
            other.adjust()
        other._triangulate(OUTLYING * other.noise * 2)
        other.adjust()
        return other

    def off(self, number: int, ids: IntArray, places: FloatArray) -> FloatArray:
        """(N,) px between where a keyframe shows points and where they are expected; NaN where not known."""
        there = projected(self.lens, local(self.poses[number], self.points[ids]))[:, :2]
        return np.asarray(np.linalg.norm(there - places, axis=1))

    def only(self, points: FloatArray) -> Growing:
        """The same keyframes by these points (L, 3) alone, NaN where there is none, adjusted. Raises Lost."""
        other = copy(self)
        other.points = points
        for _ in range(2):
            other.adjust()
        return other

    def best_points(self) -> Triangulated:
        """For all tracks; their misfit is inf where fewer than SEEN_BY keyframes show them, or tell no
        distance."""
        views, tracks, places = self._observations()
        found = triangulated(self.lens, self._stacked()[views], tracks, places, len(self.points))
        often = np.bincount(tracks, minlength=len(self.points)) >= SEEN_BY
        return replace(found, misfit=np.where(often & (found.angle > NARROWEST), found.misfit, np.inf))

    def middles(self) -> FloatArray:
        """(L, 2) px, where keyframes show each track in the mean; 0 where none does."""
        _, tracks, places = self._observations()
        total = np.zeros((len(self.points), 2))
        np.add.at(total, tracks, places)
        return total / np.maximum(np.bincount(tracks, minlength=len(total)), 1)[:, None]

    def placed(self, sight: Sight, start: FloatArray) -> Resected:
        """The pose of any frame by the points that it shows. Raises Lost."""
        ids, seen = self.seen_by(sight)
        self.require(ids)
        where = self.points[ids]
        most = MOST_MISFIT * self.lens.width / PIXEL_NOISE
        found = resected(self.lens, where, seen, [start])
        if found.misfit > most and (tried := by_chance(self.lens, where, seen)):
            found = resected(self.lens, where, seen, tried)
        if found.misfit > most:
            raise Lost(f"half of {len(ids)} points are {found.misfit * PIXEL_NOISE:.1f} px off")
        return found

    def seen_by(self, sight: Sight) -> tuple[IntArray, Seen]:
        """The points known so far that a frame shows, and where."""
        held = np.isfinite(self.points[sight.ids, 0])
        return sight.ids[held], seen_at(sight.places[held], PIXEL_NOISE)

    def require(self, ids: IntArray) -> None:
        """Raises Lost: too few points to place a view by."""
        if len(ids) < FEWEST:
            raise Lost(f"{len(ids)} points whose place is known")

    def adjust(self) -> None:
        """Bundle adjustment; points that stray are no longer known. Raises Lost: too few points are."""
        ids = self.known
        self.require(ids)
        place = np.full(len(self.points), -1)
        place[ids] = np.arange(len(ids))
        views, tracks, places = self._observations()
        held = place[tracks] >= 0
        bundle = Bundle(
            lens=self.lens,
            poses=self._stacked(),
            points=self.points[ids],
            views=views[held],
            seen_points=place[tracks[held]],
            seen=seen_at(places[held], self.noise),
            focal=self._focal if len(self.poses) >= _FREE_FROM else None,
        )
        bundle = adjusted(bundle, _ROUNDS)
        self.lens, self.points[ids] = bundle.lens, bundle.points
        self.poses = dict(zip(sorted(self.poses), bundle.poses, strict=True))
        self._adjusted_at = len(self.poses)
        off = np.linalg.norm(misfit(bundle)[:, :2], axis=1) * self.noise
        self.noise = max(_TO_DEVIATION * float(np.median(off)), _LEAST_PX) if len(off) else _FIRST_PX
        poses = bundle.poses[bundle.views]
        now = judged(bundle.lens, bundle.points, poses, bundle.seen_points, places[held])
        stray = (now.misfit > _STRAY * max(self.noise, PIXEL_NOISE)) | (now.angle < NARROWEST / 2)
        self.points[ids[stray]] = np.nan

    def _triangulate(self, most: float) -> None:
        """Tracks without a point get one where two views and more agree on it, to `most` px."""
        views, tracks, places = self._observations()
        new = np.isnan(self.points[tracks, 0])
        poses = self._stacked()[views[new]]
        found = triangulated(self.lens, poses, tracks[new], places[new], len(self.points))
        good = (found.angle > NARROWEST) & (found.misfit < most)
        self.points[good] = found.where[good]

    def _stacked(self) -> FloatArray:
        """(K, 4, 4) the poses, in the order of their keyframes."""
        return np.stack([self.poses[number] for number in sorted(self.poses)])

    def _observations(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Of all keyframes with a pose, in their order: which of them, which track, and where."""
        sights = [self._sights[number] for number in sorted(self.poses)]
        views = np.repeat(np.arange(len(sights)), [len(sight.ids) for sight in sights])
        ids, places = ([getattr(sight, name) for sight in sights] for name in ("ids", "places"))
        return views, np.concatenate(ids), np.concatenate(places)

    def _next(self, ended: Set[int]) -> set[int]:
        """Keyframes between those that have a pose, else those beside them, but for those that `ended`."""
        first, last = min(self.poses), max(self.poses)
        inside = set(range(first, last)) - self.poses.keys() - ended
        return inside or ({first - 1, last + 1} - ended) & set(range(len(self._sights)))

    def _shown(self, number: int) -> int:
        return int(np.isfinite(self.points[self._sights[number].ids, 0]).sum())

    def _nearest(self, number: int) -> FloatArray:
        return self.poses[min(self.poses, key=lambda other: (abs(other - number), other))]


def seen_at(places: FloatArray, noise: float) -> Seen:
    """(N, 2) px, of that standard deviation; the distance is not measured."""
    measured, weights = np.zeros((len(places), 3)), np.zeros((len(places), 3))
    measured[:, :2], weights[:, :2] = places, 1 / noise
    return Seen(measured, weights)
