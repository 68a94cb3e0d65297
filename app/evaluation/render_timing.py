"""The time that one image of a model takes, and its parts."""

from __future__ import annotations

import time

import numpy as np

from app.scenes.cpu_rendering import Drawn
from renderer.camera import Camera
from renderer.clip import Frame
from renderer.gaussians import DynamicGaussians
from renderer.near_plane import near_plane
from renderer.rasterize.cpu import BLACK, Rasterizer
from renderer.splats import RenderMode

REPEATS = 5
"""Drawings of a frame whose time is taken."""


class Stopwatch:
    """Draws moments of a model as a player would, its working arrays kept, and takes the time."""

    def __init__(self, model: DynamicGaussians, camera: Camera, mode: RenderMode = "default") -> None:
        self._model, self._near, self._mode = model, near_plane(model, camera), mode
        self._rasterizer = Rasterizer(camera.width, camera.height)
        self._no_tile = np.zeros((self._rasterizer.rows, self._rasterizer.columns), dtype=bool)

    def draw(self, frame: Frame) -> tuple[Drawn, dict[str, float]]:
        """The picture at the frame's time from its camera, and the milliseconds of its parts."""
        # The first lap compiles kernels, reserves arrays and wakes the threads.
        drawn, _ = self._lap(frame)
        laps = [self._lap(frame)[1] for _ in range(REPEATS)]
        whole, deformation, sorting = 1000 * np.median(laps, axis=0)
        parts = {"deformation": deformation, "projection_sort": sorting}
        return drawn, {name: float(ms) for name, ms in parts.items()} | {
            "raster": max(0.0, float(whole - deformation - sorting))
        }

    def _lap(self, frame: Frame) -> tuple[Drawn, tuple[float, float, float]]:
        """One picture; seconds of the whole, of the deformation, and of all before the raster."""
        camera, rasterizer = frame.camera, self._rasterizer
        began = time.perf_counter()
        splats = self._model.at(frame.time)
        deformed = time.perf_counter()
        rasterizer.forward(splats, camera, self._near, mode=self._mode)
        rendered = rasterizer.rendered(camera.width, camera.height, BLACK)
        done = time.perf_counter()
        rasterizer.forward(splats, camera, self._near, self._no_tile, self._mode)
        sorting = time.perf_counter() - done
        return Drawn(rendered.image, rendered.depth, rendered.alpha), (
            done - began,
            deformed - began,
            sorting,
        )
