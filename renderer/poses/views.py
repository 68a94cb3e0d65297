"""What frames show of points, and from where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from renderer.camera import Camera, FloatArray, IntArray
from renderer.clip import BoolImage
from renderer.poses.bundle import Bundle, FocalGuess
from renderer.poses.rigid_motion import Seen

PIXEL_NOISE: Final = 0.5
"""px: standard deviation of where a feature is found, before it is measured."""
DEPTH_NOISE: Final = 0.02
"""Of the inverse depth at the typical distance, before it is measured."""


@dataclass(frozen=True, eq=False)
class View:
    """What one frame shows of the points."""

    frame: int
    pose: FloatArray
    """(4, 4), camera from world, lengths in the search's unit."""
    ids: IntArray
    """(N,) which points."""
    seen: Seen
    inliers: BoolImage
    """(N,)."""


@dataclass(frozen=True, eq=False)
class Rough:
    """Views that nearly fit the points, before all are brought to agree."""

    lens: Camera
    views: tuple[View, ...]
    """In the order of their frames."""
    keys: tuple[int, ...]
    """Of the views, which are keyframes."""
    points: FloatArray
    """(L, 3) in world coordinates."""
    focal: FocalGuess | None = None
    """Where the focal length of `lens` is sought, too."""


def bundle_of(lens: Camera, views: Sequence[View], points: FloatArray, focal: FocalGuess | None) -> Bundle:
    """All that the views show of the points (L, 3)."""
    measured, weights = ([getattr(view.seen, name) for view in views] for name in ("measured", "weights"))
    return Bundle(
        lens=lens,
        poses=np.stack([view.pose for view in views]),
        points=points,
        views=np.repeat(np.arange(len(views)), [len(view.ids) for view in views]),
        seen_points=np.concatenate([view.ids for view in views]),
        seen=Seen(np.concatenate(measured), np.concatenate(weights)),
        focal=focal,
    )
