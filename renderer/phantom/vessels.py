"""Grows the phantom's vessels: branching trees whose radii follow Murray's law."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_VEINS, _ARTERIES = 2, 5
_STEP = 0.4  # mm between points of a path
_THINNEST = 0.1  # mm; thinner twigs end
_FINEST_SHARE = 0.2  # Of the root's radius; twigs end there too.


@dataclass(frozen=True, eq=False)
class Vessel:
    """A stretch between two forks."""

    path: NDArray[np.float64]
    """(N, 2) material coordinates in mm."""
    radius: float
    """mm"""
    vein: bool


@dataclass(frozen=True)
class _Bud:
    point: tuple[float, float]
    heading: float
    radius: float


def grow_vessels(rng: np.random.Generator, reach: float) -> list[Vessel]:
    """Trees that enter from a circle of radius `reach` mm: wide veins and narrower arteries."""
    vessels: list[Vessel] = []
    count = _VEINS + _ARTERIES
    turns = rng.permutation(count) * 2 * math.pi / count
    for number, turn in enumerate(turns + rng.uniform(0, 0.4, count)):
        vein = number < _VEINS
        start = (reach * math.cos(turn), reach * math.sin(turn))
        heading = turn + math.pi + rng.uniform(-0.35, 0.35)
        root = _Bud(start, heading, rng.uniform(0.6, 1.0) if vein else rng.uniform(0.3, 0.55))
        vessels.extend(Vessel(path, radius, vein) for path, radius in _grow(rng, root, reach))
    return vessels


def _grow(rng: np.random.Generator, root: _Bud, reach: float) -> Iterator[tuple[NDArray[np.float64], float]]:
    buds = [root]
    thinnest = max(_THINNEST, _FINEST_SHARE * root.radius)
    while buds:
        bud = buds.pop()
        length = rng.uniform(9, 20) * math.sqrt(bud.radius) + 2
        path, heading = _wander(rng, bud, length)
        yield path, bud.radius
        tip = (float(path[-1, 0]), float(path[-1, 1]))
        if math.hypot(*tip) > reach + 1:
            continue
        share = rng.uniform(0.08, 0.5)
        side = rng.choice([-1.0, 1.0])
        # Murray: the cubes of the daughters' radii add up to the mother's; the thinner turns off more.
        for part, angle in ((1 - share, -0.5 * share), (share, 1.15 - 0.8 * share)):
            radius = bud.radius * part ** (1 / 3)
            if radius > thinnest:
                turned = heading + side * angle + rng.normal(0, 0.12)
                buds.append(_Bud(tip, turned, radius * 0.97))


def _wander(rng: np.random.Generator, bud: _Bud, length: float) -> tuple[NDArray[np.float64], float]:
    """A winding path of `length` mm and the heading at its end; thin vessels wind more."""
    steps = max(2, round(length / _STEP))
    bends = rng.normal(0, 0.05 + 0.035 / math.sqrt(bud.radius), steps)
    # Bends swing back, so that a vessel keeps its course.
    swings = np.convolve(bends, [1, 0.7, 0.3, -0.3, -0.6, -0.5, -0.3])[:steps]
    headings = bud.heading + np.cumsum(swings)
    moves = _STEP * np.stack([np.cos(headings), np.sin(headings)], axis=1)
    path = np.concatenate([[bud.point], np.array(bud.point) + np.cumsum(moves, axis=0)])
    return path, float(headings[-1])
