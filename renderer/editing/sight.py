"""Where the Gaussians of a model are at a time, and where a camera sees their centres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.gaussians import DynamicGaussians
from renderer.model_windows import there_at, whole_at, windows_of
from renderer.splats import Float32Array, Splats

Trait = Literal["opacity", "size", "depth", "motion"]


@dataclass(frozen=True, eq=False)
class Trail:
    """The ways that the Gaussians of a model go over a clip."""

    model: DynamicGaussians
    times: Sequence[float]
    """Moments in [0, 1] of the clip, or of each window, at which the ways are looked at."""

    @cached_property
    def amplitudes(self) -> Float32Array:
        """(N,) largest distance of each centre from where it is at the first time, in the clip's unit."""
        return np.concatenate([_amplitudes(window.model, self.times) for window in windows_of(self.model)])


def _amplitudes(model: DynamicGaussians, times: Sequence[float]) -> Float32Array:
    first = model.motion.moved(model.raw, times[0]).means
    farthest = np.zeros(len(first), np.float32)
    for time in times[1:]:
        away = model.motion.moved(model.raw, time).means - first
        np.maximum(farthest, np.einsum("nc,nc->n", away, away), out=farthest)
    return np.sqrt(farthest)


@dataclass(frozen=True, eq=False)
class Sight:
    """All N Gaussians of a model at one time, as one camera sees their centres; those of other windows at
    their moment nearest to it."""

    splats: Splats
    x: Float32Array
    """(N,) pixels; NaN for those that are not before the near plane."""
    y: Float32Array
    depth: Float32Array
    """(N,) along the camera's axis, in the clip's unit."""
    there: NDArray[np.bool_]
    """(N,) those that are drawn at that time."""
    trail: Trail

    @classmethod
    def of(cls, trail: Trail, camera: Camera, time: float, near: float) -> Sight:
        """At `time` in [0, 1]; the near plane in the clip's unit."""
        splats = whole_at(trail.model, time)
        # Relative to the camera first, so that a far origin costs no more digits than the means have.
        local = splats.means - camera.position.astype(np.float32)
        across, down, depth = camera.camera_from_world[:3, :3].astype(np.float32) @ local.T
        before = np.where(depth > near, depth, np.float32(np.nan))
        x = np.float32(camera.fx) * (across / before) + np.float32(camera.cx)
        y = np.float32(camera.fy) * (down / before) + np.float32(camera.cy)
        return cls(splats, x, y, depth, there_at(trail.model, time), trail)

    def trait(self, name: Trait) -> Float32Array:
        """(N,) opacity in [0, 1]; or, in the clip's unit, the largest standard deviation, the depth, or how
        far a Gaussian moves over the clip."""
        match name:
            case "opacity":
                return self.splats.opacities
            case "size":
                largest: Float32Array = self.splats.scales.max(axis=1)
                return largest
            case "depth":
                return self.depth
            case "motion":
                return self.trail.amplitudes
