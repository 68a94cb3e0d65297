"""The tissue at rest, told from tissue that moves by itself: it is what most tracks agree on exactly.

Without depth, poses and shape together take up much of a motion of the tissue: all tracks are then off by a
little. Tissue that moves lies together, so that some region of the view shows none of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from renderer.camera import BoolArray
from renderer.poses.growing import Growing
from renderer.poses.parts import Lost
from renderer.poses.triangulation import Triangulated
from renderer.poses.views import PIXEL_NOISE

_AT_REST = 0.6
"""Share of the tracks that agree from which on no other poses are tried."""
_FEWEST = 0.25
"""Share that agrees at least with poses by some: where less does, all in view moves, and all have a say.
Of a phantom pulled in a third of the view 0.29 do, of one that breathes as well 0.21."""
_ROUNDS = 8


def steadied(growing: Growing) -> Growing:
    """The poses that most tracks agree with to PIXEL_NOISE: those given, or those by one region of the view,
    then by the tracks that agree, in turn; with the points of these alone."""
    given = best = _Tried(growing, growing.best_points())
    judged = np.isfinite(given.points.misfit).sum()
    if given.count > _AT_REST * judged:
        return growing
    for region in _regions(growing):
        best = given.by(region, best)
    for _ in range(_ROUNDS):
        before = best
        best = best.by(best.agrees, best)
        if best is before:
            break
    return best.growing if best.count > _FEWEST * judged else growing


@dataclass(frozen=True, eq=False)
class _Tried:
    """Poses, and the best points for all tracks by them."""

    growing: Growing
    points: Triangulated

    @property
    def agrees(self) -> BoolArray:
        """(L,) which tracks do."""
        return self.points.misfit < PIXEL_NOISE

    @property
    def count(self) -> int:
        return int(self.agrees.sum())

    def by(self, which: BoolArray, best: _Tried) -> _Tried:
        """The poses by these of the tracks (L,) alone, where more agree with them than with the best."""
        told = which & np.isfinite(self.points.misfit)
        try:
            other = self.growing.only(np.where(told[:, None], self.points.where, np.nan))
        except Lost:
            return best
        tried = _Tried(other, other.best_points())
        return tried if tried.count > best.count else best


def _regions(growing: Growing) -> Iterator[BoolArray]:
    """Halves and quarters of the view, its middle, and what is around that."""
    x, y = (growing.middles() / (growing.lens.width, growing.lens.height)).T
    left, top = x < 0.5, y < 0.5
    middle = (np.abs(x - 0.5) < 0.25) & (np.abs(y - 0.5) < 0.25)
    yield from (left, ~left, top, ~top, left & top, left & ~top, ~left & top, ~left & ~top, middle, ~middle)
