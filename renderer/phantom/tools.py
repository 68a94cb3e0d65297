"""The phantom's instruments: capsules that enter from outside the picture."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from renderer.camera import FloatArray

_SHAFT, _WRIST, _JAW = 3.6, 2.2, 0.8  # Radii in mm.
_WRIST_LENGTH, _JAW_LENGTH, _SHAFT_LENGTH = 7.0, 9.0, 120.0


@dataclass(frozen=True, eq=False)
class Capsule:
    """All points within `radius` mm of the segment from `start` to `end` (world, mm)."""

    start: FloatArray
    end: FloatArray
    radius: float
    shade: float
    """Albedo of its grey, in [0, 1]."""


@dataclass(frozen=True, eq=False)
class ToolHits:
    """What rays meet first among the tools; `distance` is infinite where they meet none."""

    distance: FloatArray
    """(N,) along the unit directions, mm."""
    normal: FloatArray
    """(N, 3) unit."""
    shade: FloatArray
    """(N,)"""


def instrument(tip: FloatArray, towards: FloatArray, opening: float) -> list[Capsule]:
    """A grasper whose jaws end at `tip` (3,), with its shaft along the unit vector `towards` (3,).

    `opening` is the angle between the jaws in radians.
    """
    across = np.cross(towards, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    joint = tip + _JAW_LENGTH * math.cos(opening / 2) * towards
    wrist = joint + _WRIST_LENGTH * towards
    spread = _JAW_LENGTH * math.sin(opening / 2) * across
    return [
        Capsule(joint, tip + spread, _JAW, 0.75),
        Capsule(joint, tip - spread, _JAW, 0.75),
        Capsule(wrist, joint, _WRIST, 0.55),
        Capsule(wrist + _SHAFT_LENGTH * towards, wrist + 2.0 * towards, _SHAFT, 0.34),
    ]


def hit_tools(origin: FloatArray, directions: FloatArray, capsules: Iterable[Capsule]) -> ToolHits:
    """First meeting of rays from `origin` (3,) along unit `directions` (N, 3) with any capsule."""
    count = len(directions)
    hits = ToolHits(np.full(count, np.inf), np.zeros((count, 3)), np.zeros(count))
    squared = (directions**2).sum(axis=1)
    for capsule in capsules:
        distance, foot = _hit(origin, directions, squared, capsule)
        nearer = distance < hits.distance
        point = origin + distance[nearer, None] * directions[nearer]
        hits.distance[nearer] = distance[nearer]
        hits.normal[nearer] = (point - foot[nearer]) / capsule.radius
        hits.shade[nearer] = capsule.shade
    return hits


def _hit(
    origin: FloatArray, directions: FloatArray, squared: FloatArray, capsule: Capsule
) -> tuple[FloatArray, FloatArray]:
    """Distance along each ray (infinite = missed) and the nearest point of the axis (N, 3).

    `squared` (N,) are the squares of the directions' lengths.
    """
    axis = capsule.end - capsule.start
    length = float(np.linalg.norm(axis))
    axis = axis / length
    offset = origin - capsule.start
    along_ray, along_offset = directions @ axis, float(offset @ axis)
    flat_ray = directions - along_ray[:, None] * axis
    flat_squared = (flat_ray**2).sum(axis=1)
    side = _near_root(flat_ray, flat_squared, offset - along_offset * axis, capsule.radius)
    with np.errstate(invalid="ignore"):
        height = along_offset + side * along_ray
        side = np.where((height >= 0) & (height <= length), side, np.inf)
    start = _near_root(directions, squared, offset, capsule.radius)
    end = _near_root(directions, squared, origin - capsule.end, capsule.radius)
    distance = np.minimum(np.minimum(side, start), end)
    reach = np.where(np.isfinite(distance), distance, 0.0)
    height = np.clip(along_offset + reach * along_ray, 0, length)
    return distance, capsule.start + height[:, None] * axis


def _near_root(directions: FloatArray, squared: FloatArray, offset: FloatArray, radius: float) -> FloatArray:
    """Smaller s > 0 with |offset + s directions| = radius, infinite where there is none."""
    b = directions @ offset
    c = float(offset @ offset) - radius**2
    discriminant = b * b - squared * c
    with np.errstate(divide="ignore", invalid="ignore"):
        root = (-b - np.sqrt(discriminant)) / squared
    return np.where((discriminant >= 0) & (root > 0), root, np.inf)
