"""Density control of 3D Gaussian splatting (Kerbl et al. 2023, section 5): clone, split, prune."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.raw_gaussians import RawGaussians, sigmoid
from renderer.splats import Float32Array
from renderer.stored_arrays import Arrays

SHRINK = 1.6
"""Children of a split are smaller by this."""
CHILDREN = 2


@dataclass(frozen=True, kw_only=True)
class DensityControl:
    """When Gaussians come and go. There is no reset of opacities: a model never collapses by one."""

    start: int = 500
    """First step after which it acts."""
    every: int = 100
    """Steps between two times."""
    gradient: float = 2e-4
    """Mean length of the loss's gradient by the centre on screen, in half pictures, that asks for more."""
    split_above: float = 0.0
    """Larger ones are split, others cloned: the largest standard deviation in scene sizes."""
    min_opacity: float = 0.005
    """Fainter ones are removed."""
    most: int = 200_000
    """Gaussians, at which no more are made."""
    seed: int = 0


@dataclass(frozen=True, eq=False)
class Plan:
    """What becomes of a model: which Gaussians stay or repeat, and what is new of those that repeat."""

    index: NDArray[np.int64]
    """(M,) into the present ones."""
    means: Float32Array
    """(M, 3)"""
    log_scales: Float32Array
    """(M, 3)"""
    fresh: NDArray[np.bool_]
    """(M,) True: starts without moments."""


class Densifier:
    """Gathers gradients and plans the changes. `size` is the scene size in the clip's unit."""

    def __init__(self, control: DensityControl, size: float, count: int) -> None:
        self._control, self._size = control, size
        self._sums, self._counts = np.zeros(count, np.float32), np.zeros(count, np.int32)

    def add(self, by_centers: Float32Array, seen: NDArray[np.bool_], camera: Camera) -> None:
        """Take note of a step: gradient by the centres on screen in pixels (N, 2), and who was seen (N,)."""
        half = np.float32(camera.width / 2), np.float32(camera.height / 2)
        _add_lengths(by_centers, seen, *half, self._sums, self._counts)

    def is_due(self, done: int) -> bool:
        """After `done` steps."""
        return done > self._control.start and done % self._control.every == 0

    def plan(self, raw: RawGaussians, done: int) -> Plan:
        """From what was gathered since the last time. One seed and step give the same plan."""
        control = self._control
        wanted = self._sums >= control.gradient * np.maximum(self._counts, 1)
        wanted &= self._counts > 0
        stays = sigmoid(raw.opacity_logits) >= control.min_opacity
        if np.count_nonzero(stays) + np.count_nonzero(wanted & stays) > control.most:
            wanted[:] = False
        large = np.exp(raw.log_scales.max(axis=1)) > control.split_above * self._size
        split, cloned = wanted & stays & large, wanted & stays & ~large
        kept = np.flatnonzero(stays & ~split)
        children = np.flatnonzero(split).repeat(CHILDREN)
        index = np.concatenate([kept, np.flatnonzero(cloned), children])
        means, log_scales = raw.means[index], raw.log_scales[index]
        first = len(index) - len(children)
        rng = np.random.default_rng([control.seed, done])
        means[first:] += _offsets(raw, children, rng)
        log_scales[first:] -= np.float32(np.log(SHRINK))
        fresh = np.arange(len(index)) >= len(kept)
        return Plan(index, means, log_scales, fresh)

    def start_again(self, count: int) -> None:
        """After a plan was carried out."""
        self._sums, self._counts = np.zeros(count, np.float32), np.zeros(count, np.int32)

    def state(self) -> Arrays:
        """All that later plans depend on."""
        return {"density.sums": self._sums, "density.counts": self._counts}

    def restore(self, arrays: Arrays) -> None:
        """Take over what `state` gave."""
        self._sums, self._counts = arrays["density.sums"].copy(), arrays["density.counts"].copy()


def _offsets(raw: RawGaussians, index: NDArray[np.int64], rng: np.random.Generator) -> Float32Array:
    """Points drawn from the chosen Gaussians, relative to their centres."""
    local = rng.standard_normal((len(index), 3)) * np.exp(raw.log_scales[index])
    lengths = np.linalg.norm(raw.quats[index], axis=1, keepdims=True)
    # The zero quaternion turns nothing, as in the projection.
    w, *axis = np.where(lengths > 0, raw.quats[index] / np.where(lengths > 0, lengths, 1), (1, 0, 0, 0)).T
    along = np.stack(axis, axis=1)
    across = 2 * np.cross(along, local)
    turned: Float32Array = (local + w[:, None] * across + np.cross(along, across)).astype(np.float32)
    return turned


@njit(parallel=True, cache=True, error_model="numpy")
def _add_lengths(
    by_centers: NDArray[np.float32],  # (N, 2)
    seen: NDArray[np.bool_],  # (N,)
    half_width: np.float32,
    half_height: np.float32,
    lengths: NDArray[np.float32],  # (N,), added to
    counts: NDArray[np.int32],  # (N,), added to
) -> None:
    """Length of the gradient by the centre on screen, where the picture spans -1 to 1."""
    for n in prange(len(lengths)):
        if seen[n]:
            by_u, by_v = by_centers[n, 0] * half_width, by_centers[n, 1] * half_height
            lengths[n] += np.sqrt(by_u * by_u + by_v * by_v)
            counts[n] += 1
