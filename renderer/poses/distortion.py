"""How much a lens bends straight lines, as the motion of its camera tells it, and whether that is certain."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from renderer.camera import Camera
from renderer.poses.bundle import Bundle, FocalGuess, adjusted, k1_pulls, misfit
from renderer.poses.growing import SEEN_BY, seen_at
from renderer.poses.radial import straightened
from renderer.poses.resection import FEWEST
from renderer.poses.settling import Settled
from renderer.poses.tracks import Sight, Tracked
from renderer.poses.triangulation import triangulated
from renderer.poses.views import View, bundle_of

CERTAIN: Final = 3.0
"""Standard deviations that k1 is away from none at least."""
FLOOR: Final = 0.04
"""Of k1: less is left out. Without distortion, phantoms at rest say up to 0.033."""
RIGID: Final = 0.85
"""Share of the features that agree with one body. Of phantoms at rest it is 1.00; of one that is pulled up to
0.71, where -0.2 is told as -0.13; of one that breathes up to 0.51, where none is told as -0.06; on a sinus
without distortion 0.62, where it is told as -0.07."""
_SPREAD = 0.5
"""Standard deviation of k1 before anything is seen."""
_TIMES = 5
"""That views show a feature, in the median: those between are left out."""
_MOST_VIEWS = 40
_TURNS, _ROUNDS, _ENOUGH, _SAME = 12, 20, 1e-6, 1e-3
"""Of the search, which ends where a turn changes k1 by less. A focal length that is too short by 5 % stays so
by 4 % where bundle adjustment ends at a gain of 1e-5 of the cost, and by 2 % here."""
_LEAST_PX = 0.02
_AGREES = 3.0
"""Times the noise, up to which a feature agrees."""


@dataclass(frozen=True)
class Distortion:
    """Of one lens, which shows at a slant s from its axis what one without shows at s (1 + k1 |s|^2)."""

    k1: float
    deviation: float
    """Standard deviation of that."""
    lens: Camera
    """With the focal length that belongs to it."""
    rigid: float
    """Share of the features that agree with one body."""

    @property
    def is_certain(self) -> bool:
        """Whether k1 may be used: elsewhere tissue that moves, or wrong features, may say it."""
        is_told = abs(self.k1) > max(CERTAIN * self.deviation, FLOOR)
        return is_told and self.rigid >= RIGID


def distortion_of(done: Settled, parts: Sequence[Tracked], focal: FocalGuess) -> Distortion | None:
    """k1 with which views, points and the focal length fit best, from those that were found without it;
    `parts` have the features. None: too few of these tell it."""
    views = _looked_at(done.views)
    start = _bundle(done, views, focal)
    bundle = _settled(start) if len(start.points) >= FEWEST else None
    if bundle is None:
        return None
    sights = {sight.frame: sight for part in parts for sight in part.sights}
    rigid = _rigid(bundle, [sights[view.frame] for view in views])
    return Distortion(bundle.k1, _deviation(bundle), bundle.lens, rigid)


def _settled(bundle: Bundle) -> Bundle | None:
    """With its k1; None: it keeps changing, or what is seen does not hold the poses."""
    with suppress(np.linalg.LinAlgError):
        for _ in range(_TURNS):
            before = bundle.k1
            bundle = _weighed(adjusted(bundle, _ROUNDS, _ENOUGH))
            if abs(bundle.k1 - before) < _SAME:
                return bundle
    return None


def _looked_at(views: Sequence[View]) -> Sequence[View]:
    """As few as show a feature _TIMES; of a long clip those in its middle."""
    shown = np.bincount(np.concatenate([view.ids for view in views]))
    step = max(1, int(np.median(shown[shown > 0])) // _TIMES)
    taken = views[::step]
    start = max(0, (len(taken) - _MOST_VIEWS) // 2)
    return taken[start : start + _MOST_VIEWS]


def _bundle(done: Settled, views: Sequence[View], focal: FocalGuess) -> Bundle:
    """Of points that SEEN_BY of the views show, by where they are seen alone."""
    whole = bundle_of(done.lens, views, done.points, focal)
    often = np.bincount(whole.seen_points)[whole.seen_points] >= SEEN_BY
    kept, seen_points = np.unique(whole.seen_points[often], return_inverse=True)
    return replace(
        whole, points=done.points[kept], views=whole.views[often], seen_points=seen_points,
        seen=seen_at(whole.seen.measured[often, :2], done.noise.pixel), k1_spread=_SPREAD,
    )  # fmt: skip


def _weighed(bundle: Bundle) -> Bundle:
    """By the noise that is left over in the median of the points: what the place of each and the poses do not
    take up is a sum of squares, whose median is as Wilson and Hilferty (1931) have it."""
    squares = ((misfit(bundle)[:, :2] / bundle.seen.weights[:, :2]) ** 2).sum(axis=1)
    times, total = np.bincount(bundle.seen_points), np.bincount(bundle.seen_points, weights=squares)
    free = np.maximum(2 * times - 3 - 6 * len(bundle.poses) * times / len(squares), 1.0)
    noise = math.sqrt(float(np.median(total / (free * (1 - 2 / (9 * free)) ** 3))))
    return replace(bundle, seen=seen_at(bundle.seen.measured[:, :2], max(noise, _LEAST_PX)))


def _deviation(bundle: Bundle) -> float:
    """As the noise has it, or where that is more as points disagree: errors of one feature go together."""
    pulls = k1_pulls(bundle)
    each = np.bincount(bundle.seen_points, weights=(pulls * misfit(bundle)).sum(axis=1))
    return float(max(np.linalg.norm(pulls), np.linalg.norm(each)))


def _rigid(bundle: Bundle, sights: Sequence[Sight]) -> float:
    """Of the features that SEEN_BY of the views show, the share that one point each is seen as."""
    ids, places = (np.concatenate([getattr(sight, name) for sight in sights]) for name in ("ids", "places"))
    poses = np.repeat(bundle.poses, [len(sight.ids) for sight in sights], axis=0)
    straight = straightened(bundle.lens, places, bundle.k1)
    found = triangulated(bundle.lens, poses, ids, straight, int(ids.max()) + 1)
    most = _AGREES / float(bundle.seen.weights[0, 0])
    return float(np.mean(found.misfit[np.bincount(ids) >= SEEN_BY] < most))
