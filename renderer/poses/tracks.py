"""Features of the tissue, followed from frame to frame before anything is known of where they are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from renderer.camera import FloatArray, IntArray
from renderer.clip import ByteImage
from renderer.poses.features import APART, described, followed_on, found_features
from renderer.poses.parts import Lost
from renderer.poses.pictures import Picture

FEWEST_TRACKS: Final = 40
_FEATURES = 800
_KEPT = 0.7
"""Share of a keyframe's features below which the next one is made."""
_FAR = 0.06
"""Of the width: features that moved farther look different, and the next keyframe is made."""
_LATEST = 5
"""Frames after which the next keyframe is made in any case."""


@dataclass(frozen=True, eq=False)
class Sight:
    """Where one frame shows which tracks."""

    frame: int
    ids: IntArray
    """(N,)."""
    places: FloatArray
    """(N, 2) column and row in px."""


@dataclass(frozen=True, eq=False)
class Tracked:
    """Frames through which features were followed."""

    sights: tuple[Sight, ...]
    keys: tuple[int, ...]
    """Of the sights, which are of keyframes; the first is one."""
    count: int
    """Of the tracks."""
    looks: tuple[ByteImage, ...] = ()
    """How each keyframe shows its tracks, (N, 32) as `described`; none where that was not looked at."""

    def between(self, first: int, last: int) -> Tracked:
        """From one keyframe to another, by their numbers; with what follows the last of all."""
        start, end = self.keys[first], [*self.keys, len(self.sights)][last + 1]
        keys = tuple(key - start for key in self.keys[first : last + 1])
        return Tracked(self.sights[start:end], keys, self.count, self.looks[first : last + 1])

    def with_more(self, seen: Mapping[int, tuple[IntArray, FloatArray]]) -> Tracked:
        """The same where keyframes, by their numbers, show more tracks (T,) at (T, 2) px."""
        sights = list(self.sights)
        for number, (ids, places) in seen.items():
            sight = sights[self.keys[number]]
            sights[self.keys[number]] = replace(
                sight, ids=np.r_[sight.ids, ids], places=np.concatenate([sight.places, places])
            )
        return replace(self, sights=tuple(sights), looks=())


class Tracks:
    """Features through one part of a clip; each keyframe adds new ones."""

    def __init__(self, picture: Picture) -> None:
        """Raises Lost: the frame shows too few features."""
        self.sights: list[Sight] = []
        self.keys: list[int] = []
        """Of the sights, which are of keyframes."""
        self.count = 0
        self._looks: list[ByteImage] = []
        self._key_grey: ByteImage = picture.grey
        self._previous: ByteImage = picture.grey
        self._in_key = np.zeros((0, 2))
        """Where those features are in the newest keyframe that are still followed; how many there were."""
        self._of_key = 0
        self._open_keyframe(picture, np.zeros(0, np.int64), self._in_key)
        if self.count < FEWEST_TRACKS:
            raise Lost(f"{self.count} features found, at least {FEWEST_TRACKS} are needed")

    @property
    def last(self) -> int:
        return self.sights[-1].frame

    @property
    def tracked(self) -> Tracked:
        return Tracked(tuple(self.sights), tuple(self.keys), self.count, tuple(self._looks))

    def __len__(self) -> int:
        return len(self.sights)

    def follow(self, picture: Picture, share: float = 0.0) -> None:
        """By at least this share of the newest features. Raises Lost: too few are found again; the next frame
        may be tried."""
        now = self.sights[-1]
        there, kept = followed_on(picture, self._previous, self._key_grey, now.places, self._in_key)
        if len(kept) < max(FEWEST_TRACKS, share * len(now.ids)):
            raise Lost(f"{len(kept)} features followed")
        ids, places, self._in_key = now.ids[kept], there[kept], self._in_key[kept]
        moved = np.median(np.linalg.norm(places - self._in_key, axis=1))
        late = len(self.sights) - self.keys[-1] >= _LATEST
        if late or len(kept) < _KEPT * self._of_key or moved > _FAR * picture.grey.shape[1]:
            self._open_keyframe(picture, ids, places)
        else:
            self.sights.append(Sight(picture.index, ids, places))
            self._previous = picture.grey

    def _open_keyframe(self, picture: Picture, ids: IntArray, places: FloatArray) -> None:
        apart = APART * picture.grey.shape[1]
        fresh = found_features(picture, places, _FEATURES - len(ids), apart)
        new = np.arange(self.count, self.count + len(fresh))
        self.count += len(fresh)
        self.keys.append(len(self.sights))
        self.sights.append(Sight(picture.index, np.r_[ids, new], np.concatenate([places, fresh])))
        self._looks.append(described(picture.grey, self.sights[-1].places))
        self._key_grey = self._previous = picture.grey
        self._in_key, self._of_key = self.sights[-1].places, len(self.sights[-1].ids)
