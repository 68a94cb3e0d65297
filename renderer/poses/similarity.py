"""Turns, shifts and changes of scale of a whole scene, which no camera can tell."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from renderer.camera import FloatArray


@dataclass(frozen=True, eq=False)
class Similarity:
    """From points (N, 3) to exp(scale) * turn @ point + shift."""

    turn: FloatArray
    """(3,) rotation vector."""
    scale: float
    shift: FloatArray
    """(3,)."""

    def __call__(self, points: FloatArray) -> FloatArray:
        turn = cv2.Rodrigues(self.turn)[0]
        return np.asarray(math.exp(self.scale) * points @ turn.T + self.shift)

    def carried(self, pose: FloatArray) -> FloatArray:
        """The pose (4, 4) from which points that are moved look as they did."""
        turn = cv2.Rodrigues(self.turn)[0]
        found = np.eye(4)
        found[:3, :3] = pose[:3, :3] @ turn.T
        found[:3, 3] = math.exp(self.scale) * pose[:3, 3] - found[:3, :3] @ self.shift
        return found

    def vector(self) -> FloatArray:
        """(7,)."""
        return np.asarray(np.r_[self.turn, self.scale, self.shift])
