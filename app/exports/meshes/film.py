"""A surface through time as few moments, between which its vertices go straight; of a model in windows a
surface of each, shown while its window shows most."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.scenes.scene import Scene
from app.scenes.surfaces import surface_of_window
from renderer.gaussians import DynamicGaussians
from renderer.model_windows import ModelWindow, window_at, windows_of
from renderer.splats import Float32Array
from renderer.surface.fineness import Fineness
from renderer.surface.mesh import Mesh

STRAIGHT: Final = 5e-4
"""Of the distance to the tissue, by which vertices may be off between the moments that are kept: 0.03 mm at
60 mm, less than the surface is."""


@dataclass(frozen=True, eq=False)
class Film:
    """One topology at K moments."""

    frames: range
    """Of the clip, at which it is shown."""
    mesh: Mesh
    """At the first of the moments."""
    times: tuple[float, ...]
    """(K,) of the clip, in [0, 1)."""
    positions: Float32Array
    """(K, V, 3) in the world."""
    pixels: NDArray[np.float32] | None
    """(V, 2) where each vertex is in `picture`, as shares of its size; None: vertices have colours alone."""
    picture: NDArray[np.uint8] | None
    """(H, W, 3) RGB as the fixed camera sees the model at the middle of the clip."""


def filmed(scene: Scene, fineness: Fineness) -> Generator[int, None, tuple[Film, ...]]:
    """Of every frame of the scene, window by window; yields how many have been looked at.

    Raises:
        UserError: there is no surface, or none that moves.
    """
    films = []
    for window, frames in _shares(scene):
        films.append((yield from _film(scene, window, frames, fineness)))
    return tuple(films)


def windows_left(model: DynamicGaussians) -> tuple[ModelWindow, ...]:
    """Those that have Gaussians; of a model that has none, all of them."""
    windows = windows_of(model)
    return tuple(window for window in windows if len(window)) or windows


def _shares(scene: Scene) -> Iterator[tuple[ModelWindow, range]]:
    """Each window that is left with the frames at which it shows most, in the order of time."""
    frames, windows = range(len(scene.cameras)), windows_of(scene.model)
    left = {window.index for window in windows_left(scene.model)}
    for index, group in groupby(frames, key=lambda frame: window_at(scene.model, scene.time(frame)).index):
        share = list(group)
        if index in left:
            yield windows[index], range(share[0], share[-1] + 1)


def _film(scene: Scene, window: ModelWindow, frames: range, fineness: Fineness) -> Generator[int, None, Film]:
    follower, times = surface_of_window(scene, window, fineness), [scene.time(frame) for frame in frames]
    meshes = []
    for frame, time in zip(frames, times, strict=True):
        meshes.append(follower.at(window.local(time)))
        yield frame + 1
    positions = np.stack([mesh.vertices for mesh in meshes])
    kept = straight_parts(positions, STRAIGHT * scene.distance)
    picture, pixels = follower.picture, None
    if picture is not None:
        camera = follower.cameras[0]
        places, _ = camera.project(follower.mesh.vertices.astype(np.float64))
        pixels = (places / [camera.width, camera.height]).astype(np.float32)
    return Film(frames, meshes[0], tuple(times[one] for one in kept), positions[kept], pixels, picture)


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
