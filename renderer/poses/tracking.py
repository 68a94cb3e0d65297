"""Frame by frame, where the camera is against the points that its keyframes have shown so far."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from renderer.camera import Camera, FloatArray, IntArray
from renderer.clip import BoolImage, ByteImage
from renderer.poses.features import APART, followed, followed_on, found_features
from renderer.poses.parts import Lost
from renderer.poses.pictures import Picture, at_usable, sampled_inverse
from renderer.poses.resection import FEWEST, Resected, by_chance, resected
from renderer.poses.rigid_motion import Seen, inverse, lifted, local, projected
from renderer.poses.views import DEPTH_NOISE, PIXEL_NOISE, Rough, View

_FEATURES = 600
_KEPT = 0.7
"""Share of a keyframe's features below which the next one is made."""
_FAR = 0.08
"""Of the width: features that moved farther look different, and the next keyframe is made."""
_MOST_MISFIT = 0.015
"""Of the width: half of the points moved by more on their own."""
_LATEST = 10
"""Frames after which the next keyframe is made in any case."""
_OLD_KEYFRAMES = 6
"""In which lost points are looked up."""
_ASTRAY = 1 / 20
"""Of the width, between a point found again and where the pose has it."""
_DRIFT = 1 / 100
"""Of the width, between where a point was followed to and where it looks as it did at first."""


@dataclass(eq=False)
class _Points:
    """All points of a part so far: grows."""

    where: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    key: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))
    """The keyframe that first showed each, by its number."""
    places: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    """Where, in px."""

    def add(self, where: FloatArray, key: int, places: FloatArray) -> IntArray:
        ids = np.arange(len(self.where), len(self.where) + len(where))
        self.where = np.concatenate([self.where, where])
        self.key = np.concatenate([self.key, np.full(len(where), key)])
        self.places = np.concatenate([self.places, places])
        return ids


class Tracker:
    """One part of a clip in which each frame follows from those before it."""

    def __init__(self, lens: Camera, picture: Picture) -> None:
        """Raises Lost: the frame shows too few points with depth."""
        self.lens = lens
        self.points = _Points()
        self.views: list[View] = []
        self.keys: list[int] = []
        """Of the views, which are keyframes."""
        self._greys: list[ByteImage] = []
        self._previous = picture.grey
        self._ids = np.zeros(0, np.int64)
        """Of the newest keyframe's features, those still followed: their points; where they are in it, and in
        the frame before; how many there were."""
        self._in_key = self._now = np.zeros((0, 2))
        self._of_key = 0
        self._open_keyframe(picture, np.eye(4), self._ids, self._now)
        if len(self._ids) < FEWEST:
            raise Lost(f"{len(self._ids)} points with depth")

    @property
    def last(self) -> int:
        return self.views[-1].frame

    @property
    def rough(self) -> Rough:
        return Rough(self.lens, tuple(self.views), tuple(self.keys), self.points.where)

    def __len__(self) -> int:
        return len(self.views)

    def follow(self, picture: Picture, share: float = 0.0) -> None:
        """By at least this share of the newest features. Raises Lost: no pose of this frame agrees with what
        came before; the next one may be tried."""
        there, kept = followed_on(picture, self._previous, self._greys[-1], self._now, self._in_key)
        if len(kept) < max(FEWEST, share * len(self._now)):
            raise Lost(f"{len(kept)} points followed")
        ids, in_key, now = self._ids[kept], self._in_key[kept], there[kept]
        seen = observed(picture, now)
        where = self.points.where[ids]
        starts = [self.views[-1].pose, *by_chance(self.lens, where, seen)]
        found = resected(self.lens, where, seen, starts)
        if found.misfit > _MOST_MISFIT * self.lens.width / PIXEL_NOISE:
            raise Lost(f"half of {len(ids)} points are {found.misfit * PIXEL_NOISE:.1f} px off")
        self._ids, self._in_key, self._now, self._previous = ids, in_key, now, picture.grey
        self.views.append(View(picture.index, found.pose, ids, seen, found.inliers))
        moved = np.median(np.linalg.norm(now - in_key, axis=1))
        late = len(self.views) - self.keys[-1] > _LATEST
        if late or len(ids) < _KEPT * self._of_key or moved > _FAR * self.lens.width:
            self._renew(picture, found)

    def _as_first_seen(self, picture: Picture, ids: IntArray, now: FloatArray) -> tuple[IntArray, FloatArray]:
        """Points that look as they did at first, and where: followed over keyframes, they drift."""
        there, kept = now.copy(), np.zeros(len(ids), bool)
        for key in np.unique(self.points.key[ids]):
            of = np.flatnonzero(self.points.key[ids] == key)
            there[of], kept[of] = self._looked_up(picture, int(key), ids[of], now[of], _DRIFT, levels=1)
        return ids[kept], there[kept]

    def _renew(self, picture: Picture, found: Resected) -> None:
        """The frame becomes a keyframe: what it shows beside what was followed is found."""
        ids, now = self._as_first_seen(picture, self._ids[found.inliers], self._now[found.inliers])
        old, places = self._found_again(picture, found.pose, ids)
        self.views.pop()
        self._open_keyframe(picture, found.pose, np.r_[ids, old], np.concatenate([now, places]))

    def _open_keyframe(self, picture: Picture, pose: FloatArray, ids: IntArray, places: FloatArray) -> None:
        fresh = found_features(picture, places, _FEATURES - len(ids), APART * self.lens.width)
        nearness = sampled_inverse(picture, fresh)
        fresh, nearness = fresh[nearness > 0], nearness[nearness > 0]
        where = lifted(self.lens, np.c_[fresh, nearness])
        back = inverse(pose)
        new = self.points.add(local(back, where), len(self._greys), fresh)
        self._ids, self._now = np.r_[ids, new], np.concatenate([places, fresh])
        self._in_key, self._of_key = self._now, len(self._ids)
        self.keys.append(len(self.views))
        self._greys.append(picture.grey)
        seen = observed(picture, self._now)
        self.views.append(View(picture.index, pose, self._ids, seen, np.ones(len(self._ids), bool)))

    def _found_again(
        self, picture: Picture, pose: FloatArray, known: IntArray
    ) -> tuple[IntArray, FloatArray]:
        """Points that were lost on the way and are in view again: this keeps drift small."""
        places = local(pose, self.points.where)
        expected = projected(self.lens, places)
        looked = at_usable(picture, expected[:, :2]) & (places[:, 2] > 0)
        looked[known] = False
        per_key = np.bincount(self.points.key[looked], minlength=len(self._greys))
        found, where = [np.zeros(0, np.int64)], [np.zeros((0, 2))]
        for key in np.argsort(-per_key, kind="stable")[:_OLD_KEYFRAMES]:
            ids = np.flatnonzero(looked & (self.points.key == key))
            there, good = self._looked_up(picture, int(key), ids, expected[ids, :2], _ASTRAY, levels=2)
            found.append(ids[good])
            where.append(there[good])
        return np.concatenate(found), np.concatenate(where)

    def _looked_up(
        self, picture: Picture, key: int, ids: IntArray, guess: FloatArray, within: float, levels: int
    ) -> tuple[FloatArray, BoolImage]:
        """Where points (N,) of a keyframe are in the picture, (N, 2), and where that is certain: at most
        `within` of the width from the guess (N, 2)."""
        there, certain = followed(self._greys[key], picture.grey, self.points.places[ids], guess, levels)
        near = np.linalg.norm(there - guess, axis=1) < within * self.lens.width
        return there, certain & near & at_usable(picture, there)


def observed(picture: Picture, places: FloatArray) -> Seen:
    """What the picture measures at (N, 2) px, with the noise that is assumed first."""
    nearness = sampled_inverse(picture, places)
    pixel = np.full(len(places), 1 / PIXEL_NOISE)
    depth = np.where(nearness > 0, 1 / DEPTH_NOISE, 0.0)
    return Seen(np.c_[places, nearness], np.stack([pixel, pixel, depth], axis=1))
