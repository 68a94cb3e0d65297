"""The camera of the 3D view away from the clip's own: turned around a point, moved, or flown."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator

from app.scenes.records import RecordedCamera
from renderer.camera import FARTHEST, Camera

MIN_DISTANCE, MAX_DISTANCE = 0.05, 20.0
"""To the point that is turned around, as shares of the scene's distance."""
MAX_PITCH = math.radians(85.0)

FloatArray = NDArray[np.float64]
Vector = tuple[float, float, float]
"""In world coordinates."""


def vector(values: FloatArray) -> Vector:
    """A tuple of (3,) numbers: a value that compares."""
    x, y, z = (float(value) for value in values)
    return x, y, z


def _direction(told: Vector) -> Vector:
    length = math.hypot(*told)
    if not abs(length - 1) <= 1e-6:
        raise ValueError(f"expected a direction of unit length, got {length:.3g}")
    return told


@dataclass(frozen=True)
class FreeView:
    """A camera with the pixels of the clip's frames, and the direction that stays down."""

    camera: RecordedCamera
    down: Annotated[Vector, AfterValidator(_direction)]
    """Unit length."""

    @classmethod
    def of(cls, camera: Camera) -> Self:
        """Seen through `camera`, which is upright."""
        down = camera.camera_from_world[1, :3]
        return cls(camera, vector(down / np.linalg.norm(down)))

    def orbited(self, around: Vector, yaw: float, pitch: float) -> FreeView:
        """Turned by radians around a point that stays where it is on screen.

        Positive angles move what is nearer than the point left and down; pitch stops before the poles, so
        that down stays down.
        """
        pose = self.camera.camera_from_world[:3]
        seen = pose[:, :3] @ around + pose[:, 3]
        elevation = math.asin(min(max(float(pose[2, :3] @ self.down), -1.0), 1.0))
        limited = min(max(elevation + pitch, -MAX_PITCH), MAX_PITCH) - elevation
        rotation = _about((1.0, 0.0, 0.0), limited) @ pose[:, :3] @ _about(self.down, yaw)
        return self._at(rotation, seen - rotation @ around)

    def looked(self, yaw: float, pitch: float) -> FreeView:
        """Turned on the spot: positive angles move what is seen right and up."""
        return self.orbited(vector(self.camera.position), yaw, pitch)

    def panned(self, around: Vector, x: float, y: float) -> FreeView:
        """Moved so that a point follows the hand by (x, y) of the camera's pixels, right and down."""
        camera = self.camera
        depth = max(self._seen(around)[2], 1e-12)
        return self._shifted(np.array([x / camera.fx * depth, y / camera.fy * depth, 0.0]))

    def zoomed(self, around: Vector, factor: float, scene_distance: float) -> FreeView:
        """Nearer, for a factor above 1, to a point that stays where it is on screen."""
        seen = self._seen(around)
        distance = float(np.linalg.norm(seen))
        if distance == 0:
            return self
        wanted = min(max(distance / factor, MIN_DISTANCE * scene_distance), MAX_DISTANCE * scene_distance)
        return self._shifted(seen * (wanted / distance - 1))

    def flown(self, right: float, down: float, forward: float) -> FreeView:
        """Moved along its own axes, in scene units."""
        return self._shifted(-np.array([right, down, forward]))

    def _seen(self, point: Vector) -> FloatArray:
        """(3,) in camera coordinates."""
        pose = self.camera.camera_from_world[:3]
        return np.asarray(pose[:, :3] @ point + pose[:, 3])

    def _shifted(self, by: FloatArray) -> FreeView:
        """With everything seen moved by (3,) camera coordinates."""
        pose = self.camera.camera_from_world
        return self._at(pose[:3, :3], pose[:3, 3] + by)

    def _at(self, rotation: FloatArray, translation: FloatArray) -> FreeView:
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = rotation, np.clip(translation, -FARTHEST, FARTHEST)
        return replace(self, camera=self.camera.moved(pose))


def _about(axis: Vector, angle: float) -> FloatArray:
    """(3, 3) rotation around a unit axis, by Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross)
