"""What a camera at rest has in view, by planes through its centre: its image, or the field of view in it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final, Protocol

import cv2
import numpy as np

from renderer.camera import BoolArray, Camera, FloatArray

IMAGE_SIDES: Final = 4
MOST_CORNERS: Final = 96
"""Of a field's outline: a circle of up to 540 px is told to half a pixel. Shaders hold as many planes."""
LOOSEST: Final = 0.25
"""Pixels by which leaving out a corner may move the outline, where few enough are left."""
LEAST_SIDE: Final = 1e-6
"""Pixels; a shorter one has no direction."""


class InView(Protocol):
    """What bounds that which is drawn, as a `Camera` does."""

    @property
    def sides(self) -> FloatArray:
        """(4 + K, 4) planes: a point is in view where `sides @ (x, y, z, 1)`, its distances to them, are all
        at least 0. The first four are the sides of an image; of the K others those count that are nearest to
        a splat, see crossings.py."""
        ...


@dataclass(frozen=True, eq=False)
class FieldInView:
    """A convex part of a camera's image."""

    camera: Camera
    outline: FloatArray
    """(K, 2) corners in pixels, in order, clockwise as seen, see `outline_of`."""

    @cached_property
    def sides(self) -> FloatArray:
        """As `InView` says it."""
        ahead = np.roll(self.outline, -1, axis=0) - self.outline
        long = np.linalg.norm(ahead, axis=1) > LEAST_SIDE
        inwards = np.stack([-ahead[long, 1], ahead[long, 0]], axis=1)
        offsets = -(inwards * self.outline[long]).sum(axis=1)
        normals = np.column_stack([inwards, offsets]) @ self.camera.intrinsics
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        sides: FloatArray = np.concatenate([self.camera.sides, normals @ self.camera.camera_from_world[:3]])
        return sides


def outline_of(kept: BoolArray) -> FloatArray | None:
    """(K, 2) corners of the smallest convex field around the pixels of an image (H, W) that are `kept`, to
    half a pixel; at most MOST_CORNERS. None: it is the whole image, or there is none."""
    if kept[[0, 0, -1, -1], [0, -1, 0, -1]].all() or not kept.any():
        return None
    rims, _ = cv2.findContours(kept.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    middles = cv2.convexHull(np.concatenate(rims))[:, 0] + 0.5
    # A straight side runs half a pixel beyond the middles, a slanted one some less.
    around = (middles[:, None] + [(0.5, 0), (-0.5, 0), (0, 0.5), (0, -0.5)]).reshape(-1, 2)
    outline, off = cv2.convexHull(around.astype(np.float32)), LOOSEST
    while len(fewer := cv2.approxPolyDP(outline, off, closed=True)) > MOST_CORNERS:
        off *= 1.2
    corners: FloatArray = fewer[:, 0].astype(np.float64)
    ahead = np.roll(corners, -1, axis=0)
    turns = (corners[:, 0] * ahead[:, 1] - corners[:, 1] * ahead[:, 0]).sum()
    return corners if turns > 0 else corners[::-1]
