"""What can be selected: parts of the picture, of space, and ranges of what Gaussians are like.

Gaussians are selected by their centres, through the whole depth of the scene.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.editing.mask import Mask
from renderer.editing.sight import Sight, Trait

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Rectangle:
    """Of the picture: pixel positions, borders included."""

    left: float
    top: float
    right: float
    bottom: float

    def contains(self, sight: Sight) -> NDArray[np.bool_]:
        across = (sight.x >= self.left) & (sight.x <= self.right)
        return across & (sight.y >= self.top) & (sight.y <= self.bottom)


@dataclass(frozen=True)
class Lasso:
    """Of the picture: the inside of a closed line, where a line that crosses itself turns inside out."""

    corners: tuple[tuple[float, float], ...]
    """Pixel positions; the last is joined to the first."""

    def contains(self, sight: Sight) -> NDArray[np.bool_]:
        inside = np.zeros(len(sight.x), np.bool_)
        if len(self.corners) > 2:
            mark_inside(sight.x, sight.y, np.array(self.corners, np.float32), inside)
        return inside


@dataclass(frozen=True)
class Sphere:
    """Of space, at the time that is seen; in the clip's unit."""

    center: Point
    radius: float

    def contains(self, sight: Sight) -> NDArray[np.bool_]:
        away = sight.splats.means - np.array(self.center, np.float32)
        within: NDArray[np.bool_] = np.einsum("nc,nc->n", away, away) <= np.float32(self.radius) ** 2
        return within


@dataclass(frozen=True)
class Box:
    """Of space, along the world's axes, at the time that is seen; in the clip's unit."""

    center: Point
    half: Point
    """Half of each edge."""

    def contains(self, sight: Sight) -> NDArray[np.bool_]:
        away = np.abs(sight.splats.means - np.array(self.center, np.float32))
        within = away <= np.array(self.half, np.float32)
        return within[:, 0] & within[:, 1] & within[:, 2]


@dataclass(frozen=True)
class Range:
    """From `low` to `high`, both included, of a trait; see Sight.trait for units."""

    trait: Trait
    low: float
    high: float

    def contains(self, sight: Sight) -> NDArray[np.bool_]:
        values = sight.trait(self.trait)
        return (values >= np.float32(self.low)) & (values <= np.float32(self.high))


@dataclass(frozen=True)
class Present:
    """What is drawn at the time that is seen: of a model in windows, the Gaussians of one or two of them."""

    def contains(self, sight: Sight) -> NDArray[np.bool_]:
        return sight.there


Region = Rectangle | Lasso | Sphere | Box | Range | Present


def found(region: Region, sight: Sight) -> Mask:
    """The Gaussians whose centres lie in the region."""
    return Mask.of(region.contains(sight))


@njit(parallel=True, cache=True, error_model="numpy")
def mark_inside(
    x: NDArray[np.float32],  # (N,), NaN is outside
    y: NDArray[np.float32],
    corners: NDArray[np.float32],  # (V, 2)
    inside: NDArray[np.bool_],  # (N,), out
) -> None:
    """Even-odd rule: a ray to the right crosses the line an odd number of times."""
    left, right = corners[:, 0].min(), corners[:, 0].max()
    top, bottom = corners[:, 1].min(), corners[:, 1].max()
    for n in prange(len(x)):
        px, py = x[n], y[n]
        odd = False
        if left <= px <= right and top <= py <= bottom:
            ax, ay = corners[-1, 0], corners[-1, 1]
            for v in range(len(corners)):
                bx, by = corners[v, 0], corners[v, 1]
                if (ay > py) != (by > py) and px < ax + (py - ay) * (bx - ax) / (by - ay):
                    odd = not odd
                ax, ay = bx, by
        inside[n] = odd
