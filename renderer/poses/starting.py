"""The two keyframes of a clip without depth that its structure is begun from."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from renderer.camera import Camera, FloatArray, IntArray
from renderer.poses.bundle import FocalGuess
from renderer.poses.growing import Growing
from renderer.poses.parts import Lost
from renderer.poses.rigid_motion import zoomed
from renderer.poses.tracks import FEWEST_TRACKS, Tracked
from renderer.poses.two_views import WIDER, parallax, parallax_beside_zoom, second_poses

LEAST_PARALLAX: Final = 0.003
"""Of the width: what is left of the motion in the image after the best turn. Less tells no distances."""
_ENOUGH = 0.03
"""Of the width: more of it makes two views no better to begin from."""
_STILL = 0.01
"""Of the width: where features move by less, so does the camera."""
_APART = (1, 2, 3, 4, 6, 8, 12, 16, 24)
"""Keyframes, between two that may begin."""
_TRIED = 5
_LEAST_SHARE = 0.4
"""Of the tracks that both views share: so many have a place in space, or the two are no beginning."""
_CHECKED = 3
"""Frames between the two."""


@dataclass(frozen=True, eq=False)
class _Pair:
    first: int
    second: int
    """Keyframes, by their numbers."""
    one: FloatArray
    other: FloatArray
    """(N, 2) px, where they show the tracks that they share."""
    parallax: float
    """px."""
    shift: float
    """px, the median."""

    def merit(self, width: int) -> float:
        return len(self.one) * min(self.parallax / (_ENOUGH * width), 1.0)


def started(lens: Camera, tracked: Tracked, focal: FocalGuess | None) -> Growing:
    """Two keyframes and what they share, placed. Raises Lost: no two of them tell distances, and why."""
    pairs = list(_pairs(lens, tracked, focal is None))
    if not pairs:
        raise Lost("keyframes share too few features")
    if max(pair.shift for pair in pairs) < _STILL * lens.width:
        raise Lost("the camera does not move")
    telling = [pair for pair in pairs if pair.parallax > LEAST_PARALLAX * lens.width]
    if not telling or (focal is not None and _only_turns(lens, telling)):
        raise Lost("the camera only turns, and does not move from its place")
    telling.sort(key=lambda pair: -pair.merit(lens.width))
    if all(_only_zooms(lens, pair, focal is None) for pair in telling):
        raise Lost("the camera only turns or zooms, and does not move from its place")
    for pair in telling[:_TRIED]:
        tried = [each for pose in second_poses(lens, pair.one, pair.other)
                 for each in _tried(lens, tracked, focal, pair, pose)]  # fmt: skip
        if tried:
            return min(tried, key=lambda each: each[0])[1]
    raise Lost("no two frames agree on where points are: all of the view moves, or little of it is sharp")


def _only_turns(lens: Camera, pairs: Sequence[_Pair]) -> bool:
    """As seen through one lens that is wider than the guess."""
    least = LEAST_PARALLAX * lens.width
    lenses = (zoomed(lens, step) for step in WIDER)
    return any(all(parallax(wide, pair.one, pair.other, True) <= least for pair in pairs) for wide in lenses)


def _only_zooms(lens: Camera, pair: _Pair, focal_is_known: bool) -> bool:
    return parallax_beside_zoom(lens, pair.one, pair.other, focal_is_known) <= LEAST_PARALLAX * lens.width


def _pairs(lens: Camera, tracked: Tracked, focal_is_known: bool) -> Iterator[_Pair]:
    sights = [tracked.sights[place] for place in tracked.keys]
    for first, here in enumerate(sights):
        for apart in _APART:
            if first + apart >= len(sights):
                break
            there = sights[first + apart]
            one, other = _shared(here.ids, there.ids)
            if len(one) < FEWEST_TRACKS:
                break
            places = here.places[one], there.places[other]
            shift = float(np.median(np.linalg.norm(places[1] - places[0], axis=1)))
            yield _Pair(first, first + apart, *places, parallax(lens, *places, focal_is_known), shift)


def _shared(one: IntArray, other: IntArray) -> tuple[IntArray, IntArray]:
    _, here, there = np.intersect1d(one, other, assume_unique=True, return_indices=True)
    return here, there


def _tried(
    lens: Camera, tracked: Tracked, focal: FocalGuess | None, pair: _Pair, pose: FloatArray
) -> Iterator[tuple[float, Growing]]:
    """The beginning with the second view at `pose`, and how badly frames between the two fit it; nothing
    where too few points fit it."""
    growing = Growing(lens, tracked, focal)
    ends = tracked.keys[pair.first], tracked.keys[pair.second]
    between = np.linspace(*ends, _CHECKED + 2).round().astype(int)[1:-1]
    try:
        growing.begin(pair.first, pair.second, pose)
        if len(growing.known) < _LEAST_SHARE * len(pair.one):
            return
        worst = max(growing.placed(tracked.sights[place], np.eye(4)).misfit for place in between)
    except Lost:
        return
    if math.isfinite(worst):
        yield worst, growing
