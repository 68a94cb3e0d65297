"""The surface that one camera sees: its depth map as triangles, cut where one part hides another."""

from __future__ import annotations

from typing import Final

import numpy as np

from renderer.surface.maps import Maps
from renderer.surface.mesh import Mesh

GRAZING: Final = 0.08
"""Cosine between the line of sight and a face's normal below which the face bridges two parts."""


def height_field(maps: Maps, step: int) -> Mesh:
    """A vertex every `step` pixels where a surface is seen."""
    rows, columns = (_places(size, step) for size in maps.depth.shape)
    inside = np.ix_(rows, columns)
    points = maps.camera.unproject(maps.depth)[inside].reshape(-1, 3)
    seen = maps.seen[inside]
    places = np.arange(seen.size).reshape(seen.shape)
    corners = places[:-1, :-1], places[:-1, 1:], places[1:, :-1], places[1:, 1:]
    whole = seen[:-1, :-1] & seen[:-1, 1:] & seen[1:, :-1] & seen[1:, 1:]
    a, b, c, d = (corner[whole] for corner in corners)
    faces = np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)]).astype(np.int32)
    mesh = Mesh(points.astype(np.float32), faces, maps.color[inside].reshape(-1, 3).clip(0, 1))
    return mesh.of_faces(_faces_sight(mesh, maps)).without_specks()


def _places(size: int, step: int) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """The first and the last pixel among them."""
    count = max(2, round((size - 1) / step) + 1)
    return np.unique(np.rint(np.linspace(0, size - 1, count)).astype(np.int64))


def _faces_sight(mesh: Mesh, maps: Maps) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """(F,) True where a face is not seen edge on."""
    first, second, third = (mesh.vertices[mesh.faces[:, corner]].astype(np.float64) for corner in range(3))
    normals = np.cross(second - first, third - first)
    sight = (first + second + third) / 3 - maps.camera.position
    lengths = np.linalg.norm(normals, axis=1) * np.linalg.norm(sight, axis=1)
    return np.asarray(np.abs((normals * sight).sum(axis=1)) > GRAZING * lengths)
