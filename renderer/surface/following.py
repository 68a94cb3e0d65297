"""A mesh that goes with the tissue: along it by the model's own motion, across it by the rendered depth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera, FloatArray
from renderer.clip import ByteImage
from renderer.gaussians import DynamicGaussians
from renderer.splats import Float32Array, RenderMode
from renderer.surface.maps import Maps, displacement, maps_of, read
from renderer.surface.mesh import Mesh

NEAR: Final = 0.05
"""Share of a point's depth within which the depth rendered there is taken for that of the same tissue."""
FAINT: Final = 1e-6
"""Weight of a camera that sees another part before the point; only where none sees the point."""
TIMELY: Final = 0.1
"""Share of the clip: a frame tells most when it was taken, and 1/e of that so much earlier or later."""
UNTIMELY: Final = 1e-3
"""What it tells at any time, which decides where no other frame shows the tissue."""


@dataclass(frozen=True, eq=False)
class Follower:
    """Of one model, through the same cameras at every time."""

    model: DynamicGaussians
    cameras: tuple[Camera, ...]
    near: float
    mode: RenderMode
    mesh: Mesh
    """The surface at `time`."""
    time: float
    sights: tuple[Float32Array, ...]
    """(V,) of each camera, how much it tells of each vertex at `time`."""
    taken: tuple[float, ...]
    """When the clip was seen through each camera."""
    picture: ByteImage | None = None
    """(H, W, 3) what the only camera sees at `time`; None where several see the surface."""

    def at(self, time: float) -> Mesh:
        """The same vertices where they are at `time` in [0, 1], in the colours of then."""
        moved = self.mesh.vertices if time == self.time else self.mesh.vertices + self._displaced(time)
        views = [maps_of(self.model, time, camera, self.near, self.mode) for camera in self.cameras]
        timely = [np.float32(np.exp(-(((time - one) / TIMELY) ** 2)) + UNTIMELY) for one in self.taken]
        weights = [sight * weight for sight, weight in zip(self.sights, timely, strict=True)]
        placed = _placed(views, weights, moved)
        return self.mesh.moved(placed, seen_colors(views, weights, placed, self.mesh.colors))

    def _displaced(self, time: float) -> Float32Array:
        total, weights = np.zeros_like(self.mesh.vertices), np.zeros((len(self.mesh.vertices), 1), np.float32)
        for camera, weight in zip(self.cameras, self.sights, strict=True):
            pixels, _ = camera.project(self.mesh.vertices.astype(np.float64))
            way = displacement(self.model, (self.time, time), camera, self.near, self.mode)
            total += weight[:, None] * read(way, pixels)
            weights += weight[:, None]
        return np.divide(total, weights, out=np.zeros_like(total), where=weights > 0)


def sight(view: Maps, mesh: Mesh) -> Float32Array:
    """(V,) how squarely the camera faces each vertex, in [0, 1]; FAINT of it where something hides it."""
    pixels, depths = view.camera.project(mesh.vertices.astype(np.float64))
    facing = mesh.facing(view.camera.position) ** 2
    inside = _inside(view, pixels, depths)
    agrees = inside & (np.abs(read(view.depth, pixels) - depths) < NEAR * depths)
    weights: NDArray[np.float64] = np.where(agrees, facing, FAINT * inside)
    return weights.astype(np.float32)


def _inside(view: Maps, pixels: FloatArray, depths: FloatArray) -> NDArray[np.bool_]:
    """(N,) before the camera, within the middles of its outermost pixels, and near what it sees."""
    height, width = view.depth.shape
    edge = 1e-3
    within = (pixels > 0.5 - edge).all(axis=1) & (pixels < np.array([width, height]) - 0.5 + edge).all(axis=1)
    return within & (depths > 0) & (read(view.depth, pixels) > 0)


def _placed(views: Sequence[Maps], sights: Sequence[Float32Array], points: Float32Array) -> Float32Array:
    """The points where the cameras that see them see the surface along the line of sight."""
    total, weights = np.zeros((len(points), 3)), np.zeros((len(points), 1))
    exact = points.astype(np.float64)
    for view, weight in zip(views, sights, strict=True):
        pixels, depths = view.camera.project(exact)
        seen = _inside(view, pixels, depths)
        found = read(view.depth, pixels)
        off = np.where(seen, found - depths, 0.0)
        known = seen & (np.abs(off) < NEAR * depths)
        ray = (exact - view.camera.position) / np.where(known, depths, 1)[:, None]
        share = (weight * known)[:, None]
        total += share * off[:, None] * ray
        weights += share
    return (exact + np.divide(total, weights, out=total, where=weights > 0)).astype(np.float32)


def seen_colors(
    views: Sequence[Maps], sights: Sequence[Float32Array], points: Float32Array, otherwise: Float32Array
) -> Float32Array:
    """(N, 3) as the cameras see them."""
    total, weights = np.zeros((len(points), 3), np.float32), np.zeros((len(points), 1), np.float32)
    for view, weight in zip(views, sights, strict=True):
        pixels, depths = view.camera.project(points.astype(np.float64))
        share = (weight * _inside(view, pixels, depths))[:, None]
        total += share * read(view.color, pixels)
        weights += share
    return np.divide(total, weights, out=otherwise.copy(), where=weights > 0).clip(0, 1)
