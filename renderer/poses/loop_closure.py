"""Tissue that a camera comes back to is the same tissue: the path of keyframes is closed there.

A keyframe that looks like one of long before shows the same place where many of its points also are where the
earlier one has them. Their tracks become one; what the path has drifted by is spread along it, and all is
adjusted anew. (Visual words: Sivic and Zisserman, 2003; loop closure over similarities: Strasdat, Montiel and
Davison, 2010.)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from renderer.camera import Camera, FloatArray, IntArray
from renderer.clip import BoolImage, ByteImage
from renderer.evenly import evenly
from renderer.poses.features import alike, followed
from renderer.poses.growing import Growing, seen_at
from renderer.poses.parts import Lost
from renderer.poses.resection import by_chance, resected
from renderer.poses.rigid_motion import NEAREST, inverse, local, projected
from renderer.poses.similarity import Similarity
from renderer.poses.tracks import Tracked
from renderer.poses.views import PIXEL_NOISE

_LOOKED_AT = 80
"""Keyframes, evenly spread, of which each is compared with those before it."""
_APART = 8
"""Keyframes between two that may close the path, at least."""
_WORDS = 512
_TRIED = 3
"""Earlier keyframes that look most like one."""
_FEWEST = 30
"""Points that agree."""
_SHARE = 0.5
"""Of what looks alike, that agrees: 0.8 to 0.97 of phantoms where half of the view is the same, 0 to 0.05 of
other places."""
_NEW = 0.3
"""Of what looks alike, that has not been followed from one to the other."""
_SHOWN, _LEFT = 0.25, 0.5
"""Of the points of the early view: a return shows at least the one share by the path as it is, and in
between less than the other share of that is shown. The noise does not tell: a path can bend so that two
places that look the same become one, on a phantom with 1.0 to 1.2 times the noise, as little as at a true
return."""
_NEAR_PX = 3.0
_FARTHEST = 0.25
"""Of the way between two keyframes, by which it may be off."""
_MOST_TURN, _MOST_SCALE = math.radians(30), 0.4
"""And by which turn, and logarithm of the scale."""
_SAME_DRIFT = 0.02
"""Of the width, to which two pairs of keyframes agree on it."""
_BESIDE = 0.1
"""Of the keyframes, between those of two such pairs."""
_STIFF = 100.0
"""Times as sure as the step from one keyframe to the next."""
_RISEN = 2.0
"""Times the noise before: where it is more, what closes the path is wrong. Of phantoms at rest it is 1.1 to
1.3, of those that are pulled or breathe, which a path that drifts takes up, 1.4 to 1.5."""
_HELD, _HELD_PX = 0.8, 2.0
"""Share of the points that close the path which agree at last, to so many px."""


@dataclass(frozen=True, eq=False)
class Closed:
    """Keyframes and tracks where the path is closed."""

    growing: Growing
    part: Tracked
    frames: tuple[tuple[int, int], ...] = ()
    """That show the same place, the earlier one first; the pair with most points comes first."""


@dataclass(frozen=True, eq=False)
class _Meeting:
    """Two keyframes that show the same place."""

    early: int
    late: int
    """Their numbers."""
    one: IntArray
    other: IntArray
    """(P,) tracks that are the same."""
    places: FloatArray
    """(P, 2) px, where the late one has them."""
    drift: Similarity
    """From where points of the late one are to where the early one has them."""

    def frames(self, part: Tracked) -> tuple[int, int]:
        early, late = (part.sights[part.keys[each]].frame for each in (self.early, self.late))
        return early, late


def closed(growing: Growing, part: Tracked, grey: Callable[[int], ByteImage]) -> Closed:
    """All as it was where the camera comes back to nothing, or where keyframes agree less when the path is
    closed. `grey` gives a frame as the tracks were followed in it."""
    as_it_was = Closed(growing, part)
    meetings = _affirmed(list(_meetings(growing, part)), growing, part)
    ties = _ties(part, meetings, grey)
    if not ties:
        return as_it_was
    tied = part.with_more(ties)
    try:
        other = growing.moved_to(tied, _spread(sorted(growing.poses), meetings))
    except Lost:
        return as_it_was
    off = np.concatenate([other.off(number, *seen) for number, seen in ties.items()])
    if other.noise > _RISEN * growing.noise or np.mean(off < _HELD_PX) < _HELD:
        return as_it_was
    most_first = sorted(meetings, key=lambda each: -len(each.one))
    return Closed(other, tied, tuple(each.frames(part) for each in most_first))


def _ties(
    part: Tracked, meetings: Sequence[_Meeting], grey: Callable[[int], ByteImage]
) -> dict[int, tuple[IntArray, FloatArray]]:
    """Of late keyframes, by their numbers, tracks (T,) of early ones that they show again, and where, (T, 2)
    px, as exactly as a feature that is followed."""
    found: dict[int, tuple[IntArray, FloatArray]] = {}
    for meeting in meetings:
        early, late = (part.sights[part.keys[each]] for each in (meeting.early, meeting.late))
        known, places = found.get(meeting.late, (np.zeros(0, np.int64), np.zeros((0, 2))))
        fresh = ~np.isin(meeting.one, np.r_[late.ids, known])
        ids, guess = meeting.one[fresh], meeting.places[fresh]
        of = {track: at for at, track in enumerate(early.ids.tolist())}
        start = early.places[[of[track] for track in ids.tolist()]]
        there, certain = followed(grey(early.frame), grey(late.frame), start, guess, levels=0)
        kept = certain & (np.linalg.norm(there - guess, axis=1) < _NEAR_PX)
        found[meeting.late] = np.r_[known, ids[kept]], np.concatenate([places, there[kept]])
    return {number: seen for number, seen in found.items() if len(seen[0])}


def _meetings(growing: Growing, part: Tracked) -> Iterator[_Meeting]:
    if len(part.looks) != len(part.keys):
        return
    numbers = sorted(growing.poses)
    asked = evenly(numbers, _LOOKED_AT)
    returns = _returns(growing, part, asked)
    if not returns.any():
        return
    words = _words([part.looks[number] for number in asked])
    for place, late in enumerate(asked):
        earlier = [at for at in np.flatnonzero(returns[:, place]).tolist() if late - asked[at] >= _APART]
        best = sorted(earlier, key=lambda at: -float(words[at] @ words[place]))[:_TRIED]
        for at in best:
            found = _meeting(growing, part, asked[at], late)
            if found is not None and _is_drift(growing, found):
                yield found


def _returns(growing: Growing, part: Tracked, asked: Sequence[int]) -> BoolImage:
    """(K, K) whether, by the path as it is, the second of two keyframes shows the points of the first, and
    one between them clearly fewer: where none does, tracks tie them all along the way."""
    found = np.zeros((len(asked), len(asked)), bool)
    for place, early in enumerate(asked):
        points = growing.points[part.sights[part.keys[early]].ids]
        points = points[np.isfinite(points[:, 0])]
        shown = np.array([_shown(growing.lens, growing.poses[late], points) for late in asked[place:]])
        least = np.minimum.accumulate(shown)
        found[place, place:] = (shown > _SHOWN * len(points)) & (least < _LEFT * shown)
    return found


def _shown(lens: Camera, pose: FloatArray, points: FloatArray) -> int:
    """How many are in view."""
    there = local(pose, points)
    places = projected(lens, there)[:, :2]
    inside = ((places > 0) & (places < (lens.width, lens.height))).all(axis=1)
    return int((inside & (there[:, 2] > 0)).sum())


def _words(looks: Sequence[ByteImage]) -> FloatArray:
    """(K, W) how often each keyframe shows each of W looks, those that few show counting most; length 1."""
    every = np.concatenate(looks)
    chosen = every[np.linspace(0, len(every) - 1, min(_WORDS, len(every))).astype(int)]
    matcher = cv2.BFMatcher(cv2.NORM_HAMMING)
    nearest = [[each.trainIdx for each in matcher.match(look, chosen)] for look in looks]
    often = np.stack([np.bincount(each, minlength=len(chosen)) for each in nearest])
    rare = np.log(len(looks) / np.maximum((often > 0).sum(axis=0), 1))
    counts = np.sqrt(often) * rare
    return np.asarray(counts / np.maximum(np.linalg.norm(counts, axis=1, keepdims=True), 1e-12))


def _meeting(growing: Growing, part: Tracked, early: int, late: int) -> _Meeting | None:
    """Of points that are known and look alike, those that the late keyframe shows as seen from one pose; None
    where they are too few."""
    here, there = (part.sights[part.keys[each]] for each in (early, late))
    held = [np.flatnonzero(np.isfinite(growing.points[sight.ids, 0])) for sight in (here, there)]
    one, other = alike(part.looks[early][held[0]], part.looks[late][held[1]])
    least = max(_FEWEST, _SHARE * len(one))
    ids, same, places = here.ids[held[0][one]], there.ids[held[1][other]], there.places[held[1][other]]
    where, seen = growing.points[ids], seen_at(places, PIXEL_NOISE)
    starts = by_chance(growing.lens, where, seen) if len(one) >= least else []
    if not starts:
        return None
    pose = resected(growing.lens, where, seen, starts).pose
    from_there = local(pose, where)
    off = np.linalg.norm(projected(growing.lens, from_there)[:, :2] - places, axis=1)
    agree = (off < _NEAR_PX) & (from_there[:, 2] > 0)
    new = agree & (ids != same)
    if agree.sum() < least or new.sum() < max(_FEWEST, _NEW * len(one)):
        return None
    now = local(growing.poses[late], growing.points[same])
    scale = float(np.median(np.log(from_there[new, 2] / np.maximum(now[new, 2], NEAREST))))
    drift = _drift(growing.poses[late], pose, scale)
    return _Meeting(early, late, ids[new], same[new], places[new], drift)


def _is_drift(growing: Growing, meeting: _Meeting) -> bool:
    """Whether the path may have drifted by this: what repeats itself elsewhere is farther off."""
    keyframes = [at for at in sorted(growing.poses) if meeting.early <= at <= meeting.late]
    places = np.stack([inverse(growing.poses[at])[:3, 3] for at in keyframes])
    way = float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
    drift = meeting.drift
    shift = np.linalg.norm(drift(places[-1:]) - places[-1:])
    turn = np.linalg.norm(drift.turn)
    return bool(shift < _FARTHEST * way and turn < _MOST_TURN and abs(drift.scale) < _MOST_SCALE)


def _drift(now: FloatArray, pose: FloatArray, scale: float) -> Similarity:
    """Which takes the points that look from `now` as moved ones do from `pose`, exp(scale) times as far."""
    turn = pose[:3, :3].T @ now[:3, :3]
    shift = pose[:3, :3].T @ (math.exp(scale) * now[:3, 3] - pose[:3, 3])
    return Similarity(np.asarray(cv2.Rodrigues(turn)[0][:, 0], dtype=np.float64), scale, shift)


def _affirmed(meetings: Sequence[_Meeting], growing: Growing, part: Tracked) -> list[_Meeting]:
    """Those whose drift another pair of keyframes beside them tells, too."""
    near = max(_BESIDE * len(part.keys), 2)

    def affirms(one: _Meeting, other: _Meeting) -> bool:
        if one.late == other.late or max(abs(one.late - other.late), abs(one.early - other.early)) > near:
            return False
        pose, points = growing.poses[one.early], growing.points[one.other]
        here, there = (
            projected(growing.lens, local(pose, each.drift(points)))[:, :2] for each in (one, other)
        )
        return float(np.median(np.linalg.norm(here - there, axis=1))) < _SAME_DRIFT * growing.lens.width

    return [one for one in meetings if any(affirms(one, other) for other in meetings)]


def _spread(numbers: Sequence[int], meetings: Sequence[_Meeting]) -> list[Similarity]:
    """How each keyframe is moved, the first not at all: by as little more than the one before it as may be
    where those that meet come together. To first order in the drift."""
    count = len(numbers)
    at = {number: place for place, number in enumerate(numbers)}
    rows = [(place, place + 1, 1.0, np.zeros(7)) for place in range(count - 1)]
    rows += [(at[each.early], at[each.late], _STIFF, each.drift.vector()) for each in meetings]
    system, right = np.zeros((count, count)), np.zeros((count, 7))
    for early, late, weight, apart in rows:
        for one, other, sign in ((early, late, -1.0), (late, early, 1.0)):
            system[one, one] += weight
            system[one, other] -= weight
            right[one] += sign * weight * apart
    moves = np.zeros((count, 7))
    moves[1:] = np.linalg.solve(system[1:, 1:], right[1:])
    return [Similarity(each[:3], float(each[3]), each[4:]) for each in moves]
