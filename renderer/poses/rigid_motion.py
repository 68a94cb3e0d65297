"""Small motions of a camera, and how what it sees of points changes with them.

Lengths are in units of a distance that is typical of the scene, so that inverse depth is about 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np

from renderer.camera import Camera, FloatArray

NEAREST = 1e-3
"""Depth below which a point counts as behind the camera."""


@dataclass(frozen=True, eq=False)
class Seen:
    """What one view measures of points, and how well.

    Rows are column and row in px and the inverse depth; weight 0 = not measured.
    """

    measured: FloatArray
    """(N, 3)."""
    weights: FloatArray
    """(N, 3), one over the standard deviation."""


def local(pose: FloatArray, points: FloatArray) -> FloatArray:
    """Points (N, 3) in the axes of the camera at `pose` (4, 4), or (N, 4, 4) with one pose a point."""
    return np.asarray(np.einsum("...ij,...j->...i", pose[..., :3, :3], points) + pose[..., :3, 3])


def projected(lens: Camera, places: FloatArray) -> FloatArray:
    """Column, row and inverse depth (N, 3) of points (N, 3) in camera axes; depth is at least NEAREST."""
    z = np.maximum(places[:, 2], NEAREST)
    return np.stack(
        [lens.fx * places[:, 0] / z + lens.cx, lens.fy * places[:, 1] / z + lens.cy, 1 / z], axis=1
    )


def lifted(lens: Camera, measured: FloatArray) -> FloatArray:
    """The points (N, 3) in camera axes that are measured so (N, 3): inverse of `projected`."""
    z = 1 / measured[:, 2]
    x, y = (measured[:, 0] - lens.cx) / lens.fx * z, (measured[:, 1] - lens.cy) / lens.fy * z
    return np.stack([x, y, z], axis=1)


def slopes(lens: Camera, places: FloatArray) -> FloatArray:
    """(N, 3, 3): how `projected` changes with the places (N, 3)."""
    z = np.maximum(places[:, 2], NEAREST)
    found = np.zeros((len(places), 3, 3))
    found[:, 0, 0], found[:, 1, 1] = lens.fx / z, lens.fy / z
    found[:, 0, 2] = -lens.fx * places[:, 0] / z**2
    found[:, 1, 2] = -lens.fy * places[:, 1] / z**2
    found[:, 2, 2] = -1 / z**2
    return found


def lens_slopes(lens: Camera, places: FloatArray) -> FloatArray:
    """(N, 3): how `projected` changes with the logarithm of the focal length, see `zoomed`."""
    z = np.maximum(places[:, 2], NEAREST)
    across, down = lens.fx * places[:, 0] / z, lens.fy * places[:, 1] / z
    return np.stack([across, down, np.zeros_like(z)], axis=1)


def zoomed(lens: Camera, step: float) -> Camera:
    """The lens with a focal length exp(`step`) times as long."""
    return replace(lens, fx=lens.fx * math.exp(step), fy=lens.fy * math.exp(step))


def motion_slopes(places: FloatArray) -> FloatArray:
    """(N, 3, 6): how places (N, 3) in camera axes change with a small turn and shift of them, see `moved`."""
    x, y, z = places.T
    none, one = np.zeros_like(x), np.ones_like(x)
    rows = [
        [none, z, -y, one, none, none],
        [-z, none, x, none, one, none],
        [y, -x, none, none, none, one],
    ]
    return np.asarray(np.moveaxis(np.array(rows), 2, 0))


def inverse(pose: FloatArray) -> FloatArray:
    """World from camera, of camera from world, and the other way round."""
    back = np.eye(4)
    back[:3, :3] = pose[:3, :3].T
    back[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return back


def in_unit(pose: FloatArray, factor: float) -> FloatArray:
    """The pose (4, 4) where lengths are `factor` times as large."""
    scaled = pose.copy()
    scaled[:3, 3] *= factor
    return scaled


def moved(pose: FloatArray, step: FloatArray) -> FloatArray:
    """The pose (4, 4) after a turn by step[:3] in radians and a shift by step[3:], in the camera's axes."""
    turn = np.eye(4)
    turn[:3, :3] = cv2.Rodrigues(step[:3])[0]
    turn[:3, 3] = step[3:]
    return np.asarray(turn @ pose)
