"""Features of the tissue, and where they are in other pictures."""

from __future__ import annotations

from typing import Any, Final

import cv2
import numpy as np

from renderer.camera import FloatArray, IntArray
from renderer.clip import BoolImage, ByteImage
from renderer.poses.pictures import Picture, at_usable

APART: Final = 1 / 80
"""Of the width, between features."""
_QUALITY = 0.01
_WINDOW = 21  # px
_CLOSING = 0.7
"""px between a feature and where tracking it there and back ends."""
_DESCRIBED = 320
"""px: wider pictures are made smaller before features are described, by 31 px around each."""
_MOST_BITS, _CLEARLY = 64, 0.85
"""Of 256, in which two that look alike differ; and of those in which the next one differs."""
_AROUND = 40
"""px, of the picture mirrored at its edges, so that all features are described."""


def found_features(picture: Picture, taken: FloatArray, most: int, apart: float) -> FloatArray:
    """(N, 2) column and row of at most so many corners (Shi and Tomasi, 1994), `apart` px from each other
    and from those that are `taken` (M, 2)."""
    free = picture.usable.astype(np.uint8)
    for x, y in np.floor(taken).astype(int):
        cv2.circle(free, (int(x), int(y)), round(apart), (0,), cv2.FILLED)
    if most < 1:
        return np.zeros((0, 2))
    found: Any = cv2.goodFeaturesToTrack(picture.grey, most, _QUALITY, apart, mask=free)
    return np.zeros((0, 2)) if found is None else found[:, 0].astype(np.float64) + 0.5


def followed_on(
    picture: Picture, before: ByteImage, key: ByteImage, now: FloatArray, in_key: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Where features (N, 2) are in a picture that were at `now` in the one before, and which of them are on
    usable tissue and look as they do at `in_key` in their keyframe."""
    there, certain = followed(before, picture.grey, now, now)
    there, firm = followed(key, picture.grey, in_key, there, levels=1)
    return there, np.flatnonzero(certain & firm & at_usable(picture, there))


def followed(
    before: ByteImage, after: ByteImage, places: FloatArray, guess: FloatArray, levels: int = 3
) -> tuple[FloatArray, BoolImage]:
    """Where features (N, 2) of one picture are in another, looked for near `guess` (N, 2), and where that is
    certain (Lucas and Kanade, 1981, in OpenCV; there and back)."""
    if not len(places):
        return places, np.zeros(0, dtype=bool)
    start, near = ((each - 0.5).astype(np.float32)[:, None] for each in (places, guess))
    options: dict[str, Any] = {
        "winSize": (_WINDOW, _WINDOW), "maxLevel": levels, "flags": cv2.OPTFLOW_USE_INITIAL_FLOW,
        "criteria": (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 30, 0.003),
    }  # fmt: skip
    there, found, _ = cv2.calcOpticalFlowPyrLK(before, after, start, near.copy(), **options)
    back, found_back, _ = cv2.calcOpticalFlowPyrLK(after, before, there, start.copy(), **options)
    apart = np.linalg.norm((back - start)[:, 0], axis=1)
    moved = there[:, 0].astype(np.float64) + 0.5
    height, width = after.shape
    inside = ((moved > 0) & (moved < (width, height))).all(axis=1)
    certain = (found[:, 0] > 0) & (found_back[:, 0] > 0) & (apart < _CLOSING) & inside
    return moved, np.asarray(certain)


def described(grey: ByteImage, places: FloatArray) -> ByteImage:
    """(N, 32) bytes that say how a picture looks around features (N, 2): what looks alike has most bits in
    common (ORB of Rublee et al., 2011, in OpenCV). A picture that is turned by more than some 20 degrees
    looks different."""
    if not len(places):
        return np.zeros((0, 32), np.uint8)
    shrink = min(1.0, _DESCRIBED / grey.shape[1])
    small = cv2.resize(grey, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    wide = cv2.copyMakeBorder(small, _AROUND, _AROUND, _AROUND, _AROUND, cv2.BORDER_REFLECT_101)
    points = [cv2.KeyPoint(float(x), float(y), 31.0, 0.0) for x, y in places * shrink - 0.5 + _AROUND]
    _, found = cv2.ORB.create().compute(wide, points)
    return np.asarray(found, dtype=np.uint8)


def alike(one: ByteImage, other: ByteImage) -> tuple[IntArray, IntArray]:
    """Of features as they are `described`, (N, 32) and (M, 32), those that look like each other and clearly
    less like any other: which of the first and of the second, (P,) each."""
    if min(len(one), len(other)) < 2:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    there, back = _best(one, other), _best(other, one)
    first = np.flatnonzero((there >= 0) & (back[there] == np.arange(len(one))))
    return first, there[first]


def _best(one: ByteImage, other: ByteImage) -> IntArray:
    """(N,) which of the second looks most like each of the first; -1 where that is not certain."""
    found = cv2.BFMatcher(cv2.NORM_HAMMING).knnMatch(one, other, k=2)
    bits = np.array([[each.distance for each in row] for row in found])
    best = np.array([row[0].trainIdx for row in found], dtype=np.int64)
    return np.where((bits[:, 0] <= _MOST_BITS) & (bits[:, 0] < _CLEARLY * bits[:, 1]), best, -1)
