"""The tissue at rest, told from tissue that moves by itself: it is what most tracks agree on exactly.

Without depth, poses and shape together take up much of a motion of the tissue: all tracks are then off by a
little. Tissue that moves lies together, so that some region of the view shows none of it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from renderer.poses.growing import BoolArray, Growing
from renderer.poses.parts import Lost
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
    best, count, judged = growing, int(_agreeing(growing).sum()), np.isfinite(growing.misfits()).sum()
    if count > _AT_REST * judged:
        return growing
    for region in _regions(growing):
        best, count = _better(growing, region, best, count)
    for _ in range(_ROUNDS):
        before = count
        best, count = _better(best, _agreeing(best), best, count)
        if count == before:
            break
    return best if count > _FEWEST * judged else growing


def _agreeing(growing: Growing) -> BoolArray:
    return growing.misfits() < PIXEL_NOISE


def _better(growing: Growing, which: BoolArray, best: Growing, count: int) -> tuple[Growing, int]:
    try:
        other = growing.only(which)
    except Lost:
        return best, count
    now = int(_agreeing(other).sum())
    return (other, now) if now > count else (best, count)


def _regions(growing: Growing) -> Iterator[BoolArray]:
    """Halves and quarters of the view, its middle, and what is around that."""
    x, y = (growing.middles() / (growing.lens.width, growing.lens.height)).T
    left, top = x < 0.5, y < 0.5
    middle = (np.abs(x - 0.5) < 0.25) & (np.abs(y - 0.5) < 0.25)
    yield from (left, ~left, top, ~top, left & top, left & ~top, ~left & top, ~left & ~top, middle, ~middle)
