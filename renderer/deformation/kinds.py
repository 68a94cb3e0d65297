"""The kinds of motion that files hold, each known by the name of its last array."""

from __future__ import annotations

from collections.abc import Collection

from renderer.deformation.fdm import FlexibleMotion
from renderer.deformation.hexplane_motion import HexplaneMotion
from renderer.deformation.motion import Motion, Still
from renderer.deformation.spline_motion import SplineMotion

MOTIONS: tuple[type[Motion], ...] = (SplineMotion, FlexibleMotion, HexplaneMotion)


def motion_among(names: Collection[str]) -> type[Motion]:
    """What moves Gaussians in a file with arrays of these names."""
    return next((kind for kind in MOTIONS if kind.NAMES[-1] in names), Still)
