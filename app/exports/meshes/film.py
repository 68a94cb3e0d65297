"""A surface through time as few moments, between which its vertices go straight."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from app.scenes.scene import Scene
from renderer.splats import Float32Array
from renderer.surface.mesh import Mesh

if TYPE_CHECKING:
    from renderer.surface.following import Follower

STRAIGHT: Final = 5e-4
"""Of the distance to the tissue, by which vertices may be off between the moments that are kept: 0.03 mm at
60 mm, less than the surface is."""


@dataclass(frozen=True, eq=False)
class Film:
    """One topology at K moments."""

    mesh: Mesh
    """At the first of them."""
    times: tuple[float, ...]
    """(K,) in [0, 1)."""
    positions: Float32Array
    """(K, V, 3) in the world."""
    pixels: NDArray[np.float32] | None
    """(V, 2) where each vertex is in `picture`, as shares of its size; None: vertices have colours alone."""
    picture: NDArray[np.uint8] | None
    """(H, W, 3) RGB as the fixed camera sees the model at the middle of the clip."""


def filmed(follower: Follower, scene: Scene) -> Generator[int, None, Film]:
    """Of every frame of the scene; yields how many have been looked at."""
    times = [scene.time(frame) for frame in range(len(scene.cameras))]
    meshes = []
    for time in times:
        meshes.append(follower.at(time))
        yield len(meshes)
    positions = np.stack([mesh.vertices for mesh in meshes])
    kept = straight_parts(positions, STRAIGHT * scene.distance)
    picture, pixels = follower.picture, None
    if picture is not None:
        camera = follower.cameras[0]
        places, _ = camera.project(follower.mesh.vertices.astype(np.float64))
        pixels = (places / [camera.width, camera.height]).astype(np.float32)
    return Film(meshes[0], tuple(times[one] for one in kept), positions[kept], pixels, picture)


def straight_parts(positions: Float32Array, tolerance: float) -> list[int]:
    """Indices into (T, V, 3) from the first to the last, such that every one between two of them is within
    `tolerance` of the straight line; each part as long as can be."""
    last, kept = len(positions) - 1, [0]
    while kept[-1] < last:
        start = kept[-1]
        ends = range(start + 1, last + 1)
        too_far = (end for end in ends if not _is_straight(positions[start : end + 1], tolerance))
        kept.append(max(next(too_far, last + 1) - 1, start + 1))
    return kept


def _is_straight(part: Sequence[Float32Array] | Float32Array, tolerance: float) -> bool:
    steps = len(part) - 1
    shares = (step / steps for step in range(1, steps))
    between = (part[0] + np.float32(share) * (part[-1] - part[0]) for share in shares)
    return all(
        float(np.square(line - one).sum(axis=1).max()) <= tolerance**2
        for line, one in zip(between, part[1:-1], strict=True)
    )
