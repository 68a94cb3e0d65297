"""A triangle mesh, and what follows from it alone."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from renderer.camera import FloatArray
from renderer.splats import Float32Array

Faces = NDArray[np.int32]
LEAST_PIECE: Final = 0.01
"""Of all faces: smaller pieces that hang together with nothing else are floating Gaussians."""
LIKE: Final = 0.1
"""Of the faces of the largest piece: one with so many is no speck beside it, however many there are."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles in world space, in the clip's unit; counter-clockwise as the cameras see them.

    Raises:
        ValueError: shapes that do not agree, or faces of vertices that there are not.
    """

    vertices: Float32Array
    """(V, 3)"""
    faces: Faces
    """(F, 3) rows of `vertices`."""
    colors: Float32Array
    """(V, 3) display-referred RGB in [0, 1]."""

    def __post_init__(self) -> None:
        if self.vertices.shape != self.colors.shape or self.vertices.shape[1:] != (3,):
            raise ValueError(f"expected (V, 3) twice, got {self.vertices.shape} and {self.colors.shape}")
        least, most = self.faces.min(initial=0), self.faces.max(initial=-1)
        if least < 0 or most >= len(self.vertices):
            got = least if least < 0 else most
            raise ValueError(f"expected faces of {len(self.vertices)} vertices, got number {got}")

    @cached_property
    def normals(self) -> Float32Array:
        """(V, 3) unit, weighted by the areas of the faces around; 0 where there is none."""
        first, second, third = (
            self.vertices[self.faces[:, corner]].astype(np.float64) for corner in range(3)
        )
        areas = np.cross(second - first, third - first)
        total = np.zeros((len(self.vertices), 3))
        for axis in range(3):
            weights = np.repeat(areas[:, axis], 3)
            total[:, axis] = np.bincount(self.faces.ravel(), weights, minlength=len(total))
        lengths = np.linalg.norm(total, axis=1, keepdims=True)
        unit: FloatArray = np.divide(total, lengths, out=np.zeros_like(total), where=lengths > 0)
        return unit.astype(np.float32)

    def facing(self, place: FloatArray) -> FloatArray:
        """(V,) how squarely each vertex is seen from `place` (3,): the cosine to its normal, of either
        side."""
        ray = self.vertices.astype(np.float64) - place
        ray /= np.maximum(np.linalg.norm(ray, axis=1, keepdims=True), 1e-30)
        return np.asarray(np.abs((ray * self.normals).sum(axis=1)))

    def moved(self, vertices: Float32Array, colors: Float32Array) -> Self:
        """The same faces elsewhere."""
        return replace(self, vertices=vertices, colors=colors)

    def of_faces(self, kept: NDArray[np.bool_]) -> Self:
        """Some of the faces (F,), with the vertices that they have."""
        used, places = np.unique(self.faces[kept], return_inverse=True)
        faces: Faces = places.reshape(-1, 3).astype(np.int32)
        return replace(self, vertices=self.vertices[used], faces=faces, colors=self.colors[used])

    def without_specks(self) -> Self:
        """The pieces that are of some size."""
        if not len(self.faces):
            return self
        pieces = _pieces(self.faces, len(self.vertices))[self.faces[:, 0]]
        sizes = np.bincount(pieces)
        least = min(LEAST_PIECE * len(self.faces), LIKE * sizes.max())
        return self.of_faces(sizes[pieces] >= least)


def _pieces(faces: Faces, count: int) -> NDArray[np.int64]:
    """(V,) a vertex that stands for all that hang together with this one."""
    label = np.arange(count)
    while True:
        lowest = label[faces].min(axis=1)
        before = label.copy()
        for corner in range(3):
            np.minimum.at(label, faces[:, corner], lowest)
        label = label[label]
        if np.array_equal(label, before):
            return label
