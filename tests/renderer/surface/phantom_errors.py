"""How far a mesh is from the phantom's tissue, whose surface is known at every time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from renderer.camera import FloatArray
from renderer.phantom.surface import Surface
from renderer.splats import Float32Array
from renderer.surface.mesh import Mesh

STEPS: Final = 20
"""Of Gauss-Newton; the surface is gentle, and five are enough to 1e-6 mm."""


@dataclass(frozen=True)
class SurfaceErrors:
    """Over the vertices of a mesh at one time, in mm and degrees."""

    mean: float
    most: float
    """What 95 % of the distances do not exceed."""
    normal: float
    """Mean angle between the normals."""
    drift: float
    """Mean way along the tissue between a vertex's own point of it, since the reference, and where it is."""


def surface_errors(
    mesh: Mesh, surface: Surface, time: float, owned: FloatArray | None = None
) -> SurfaceErrors:
    """`owned` (V, 2): points of the tissue that the vertices belong to, see `material`."""
    place = material(mesh.vertices, surface, time)
    truth, along_u, along_v = surface.evaluate(place[:, 0], place[:, 1], time)
    distances = np.linalg.norm(mesh.vertices - truth, axis=1)
    normals = np.cross(along_u, along_v)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    cosines = np.abs((normals * mesh.normals).sum(axis=1))
    angles = np.degrees(np.arccos(np.clip(cosines, 0, 1)))
    drift = 0.0
    if owned is not None:
        there, _, _ = surface.evaluate(owned[:, 0], owned[:, 1], time)
        drift = float(np.linalg.norm(there - truth, axis=1).mean())
    mean, most = float(distances.mean()), float(np.percentile(distances, 95))
    return SurfaceErrors(mean, most, float(angles.mean()), drift)


def material(points: Float32Array, surface: Surface, time: float) -> FloatArray:
    """(N, 2) the tissue that is nearest to each of the points (N, 3), as u and v in mm."""
    exact = points.astype(np.float64)
    u, v = exact[:, 0].copy(), exact[:, 1].copy()
    for _ in range(STEPS):
        place, along_u, along_v = surface.evaluate(u, v, time)
        off = exact - place
        by_u, by_v = _dot(off, along_u), _dot(off, along_v)
        uu, uv, vv = _dot(along_u, along_u), _dot(along_u, along_v), _dot(along_v, along_v)
        whole = uu * vv - uv * uv
        u += (by_u * vv - by_v * uv) / whole
        v += (by_v * uu - by_u * uv) / whole
    return np.stack([u, v], axis=1)


def _dot(first: FloatArray, second: FloatArray) -> NDArray[np.float64]:
    return np.asarray((first * second).sum(axis=1))
