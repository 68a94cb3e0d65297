"""The camera of the 3D view: the clip's own camera, moved around the tissue in front of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera

MIN_DOLLY, MAX_DOLLY = 0.05, 20.0
MAX_PITCH = math.radians(85.0)


@dataclass(frozen=True)
class Orbit:
    """A departure from the clip's camera; the default is that camera itself.

    Angles in radians around a pivot on the optical axis; `pan` in units of the pivot's distance, x right
    and y down; `dolly` multiplies the distance to the pivot.
    """

    yaw: float = 0.0
    pitch: float = 0.0
    pan: tuple[float, float] = (0.0, 0.0)
    dolly: float = 1.0

    def orbited(self, yaw: float, pitch: float) -> Orbit:
        """Turned further; pitch stops before the poles so that up stays up."""
        turned = (self.yaw + yaw + math.pi) % (2 * math.pi) - math.pi
        return replace(self, yaw=turned, pitch=min(max(self.pitch + pitch, -MAX_PITCH), MAX_PITCH))

    def panned(self, x: float, y: float) -> Orbit:
        """Moved by fractions of the present distance to the pivot, so that the drag follows the hand."""
        return replace(self, pan=(self.pan[0] + x * self.dolly, self.pan[1] + y * self.dolly))

    def zoomed(self, factor: float) -> Orbit:
        """Nearer for a factor above 1."""
        return replace(self, dolly=min(max(self.dolly / factor, MIN_DOLLY), MAX_DOLLY))

    def camera(self, clip_camera: Camera, distance: float, size: tuple[int, int]) -> Camera:
        """The camera of a view of (width, height) pixels; the pivot is `distance` before the clip's camera.

        The photo's whole field stays in view, whatever the shape of the view.
        """
        width, height = size
        scale = min(width / clip_camera.width, height / clip_camera.height)
        moved = self._camera_from_camera(distance) @ clip_camera.camera_from_world
        return Camera(
            fx=clip_camera.fx * scale, fy=clip_camera.fy * scale,
            cx=clip_camera.cx * scale + (width - clip_camera.width * scale) / 2,
            cy=clip_camera.cy * scale + (height - clip_camera.height * scale) / 2,
            width=width, height=height, camera_from_world=moved,
        )  # fmt: skip

    def _camera_from_camera(self, distance: float) -> NDArray[np.float64]:
        """Orbited from clip camera coordinates: to the pivot, turn, and back by the dollied distance."""
        cos_y, sin_y = math.cos(self.yaw), math.sin(self.yaw)
        cos_p, sin_p = math.cos(self.pitch), math.sin(self.pitch)
        around_y = np.array([[cos_y, 0, sin_y], [0, 1, 0], [-sin_y, 0, cos_y]])
        around_x = np.array([[1, 0, 0], [0, cos_p, -sin_p], [0, sin_p, cos_p]])
        moved = np.eye(4)
        moved[:3, :3] = around_x @ around_y
        pivot = np.array([0.0, 0.0, distance])
        target = distance * np.array([self.pan[0], self.pan[1], self.dolly])
        moved[:3, 3] = target - moved[:3, :3] @ pivot
        return moved
