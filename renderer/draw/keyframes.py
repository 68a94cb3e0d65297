"""Splats over time as the graphics card draws them: a rest that is uploaded once, and offsets at keyframes.

Between two keyframes every value goes straight from one to the other; rotations too, which the shader then
normalises (nlerp), their signs having been aligned from keyframe to keyframe. A splat whose values all stay
within the tolerance has no offsets.
"""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from renderer.draw.records import COLOR, MEAN, OPACITY, PLACE, QUAT, SCALES, TEXELS, packed, unpacked
from renderer.evenly import evenly
from renderer.gaussians import DynamicGaussians
from renderer.projection import ALPHA_CUT
from renderer.rotations import of_nearer_sign
from renderer.splats import Float32Array, Splats

Offsets = NDArray[Any]
MOST_BYTES = 512 << 20
"""Of offsets, on the graphics card and again in memory."""
MOST_KEYFRAMES = 1024
CHECKS = 8
"""Moments between keyframes at which the error of leaving frames out is measured."""


@dataclass(frozen=True)
class Tolerance:
    """How far a value may be off: less does not move it, and float16 must hold it, or float32 does."""

    mean: float
    """In scene units: a small part of a pixel."""
    opacity: float = 5e-4
    quat: float = 5e-4
    scale: float = 2e-3
    """As a share of the scale."""
    color: float = 5e-4

    def of(self, rest: Float32Array) -> Float32Array:
        """(N, 16), for each value of the records `rest`."""
        bounds = np.ones_like(rest)
        bounds[:, MEAN], bounds[:, OPACITY] = self.mean, self.opacity
        bounds[:, QUAT], bounds[:, COLOR] = self.quat, self.color
        bounds[:, SCALES] = self.scale * rest[:, SCALES]
        return bounds


@dataclass(frozen=True, eq=False)
class Keyframes:
    """N splats at K increasing times in [0, 1], of which M have values that move."""

    rest: Splats
    """At the first keyframe."""
    times: NDArray[np.float64] = field(default_factory=lambda: np.zeros(1))
    moving: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    """(M,) rows."""
    offsets: Mapping[int, Offsets] = field(default_factory=dict)
    """(K, M, 4) float16 or float32 to add to a texel of the records; texels that do not move are left out."""
    ever_seen: NDArray[np.bool_] | None = None
    """(N,) opaque enough to be drawn at some keyframe; None: at rest."""
    error: float = 0.0
    """Greatest distance found of a mean from its place at frames left out, in scene units; 0: none is."""

    def __len__(self) -> int:
        """Keyframes."""
        return len(self.times)

    @property
    def n_bytes(self) -> int:
        """Of the offsets."""
        return sum(offsets.nbytes for offsets in self.offsets.values())

    @property
    def drawable(self) -> NDArray[np.bool_]:
        """(N,)"""
        return self.rest.opacities >= ALPHA_CUT if self.ever_seen is None else self.ever_seen

    def between(self, time: float) -> tuple[int, int, float]:
        """The keyframes before and after `time`, and how far it is on the way, in [0, 1]."""
        place = float(np.interp(time, self.times, np.arange(len(self))))
        before = int(place)
        return before, min(before + 1, len(self) - 1), place - before

    @cached_property
    def _columns(self) -> NDArray[np.float64]:
        """(3, N) means: a row at a time goes several times as fast as a point at a time."""
        return np.ascontiguousarray(self.rest.means.T, dtype=np.float64)

    def offset(self, texel: int, time: float) -> Float32Array:
        """(M, 4) to add to a texel that moves."""
        before, after, share = self.between(time)
        first: Float32Array = self.offsets[texel][before].astype(np.float32)
        if share == 0:
            return first
        second: Float32Array = self.offsets[texel][after].astype(np.float32)
        return first + np.float32(share) * (second - first)

    def depths(self, axis: NDArray[np.float64], time: float) -> NDArray[np.floating[Any]]:
        """(N,) of the means along a row (4,) of the camera's matrix."""
        x, y, z = self._columns
        depths: NDArray[np.floating[Any]] = axis[0] * x
        depths += axis[1] * y
        depths += axis[2] * z
        depths += axis[3]
        if PLACE in self.offsets:
            depths[self.moving] += self.offset(PLACE, time)[:, MEAN] @ axis[:3]
        return depths

    def at(self, time: float) -> Splats:
        """What is drawn at `time`."""
        records = packed(self.rest)
        for texel in self.offsets:
            records[self.moving, 4 * texel : 4 * texel + 4] += self.offset(texel, time)
        return unpacked(records, self.rest.harmonics)


def baked(
    model: DynamicGaussians, times: Sequence[float], tolerance: Tolerance, most_bytes: int = MOST_BYTES
) -> Keyframes:
    """The whole of `Baker` at once."""
    baker = Baker(model, times, tolerance, most_bytes)
    while not baker.advance(np.inf):
        pass
    return baker.keyframes()


class Baker:
    """Bakes a model bit by bit, so that other work need not wait.

    `times` in [0, 1], increasing, are those of the frames. Where all would take more than `most_bytes`,
    evenly chosen ones become keyframes, and what that costs is measured.
    """

    def __init__(
        self,
        model: DynamicGaussians,
        times: Sequence[float],
        tolerance: Tolerance,
        most_bytes: int = MOST_BYTES,
    ) -> None:
        self._model = model
        self._rest = model.at(times[0])
        self._last = self._first = _unit_turns(packed(self._rest))
        self._bounds = tolerance.of(self._first)
        self._times = self._chosen(np.asarray(times, np.float64), most_bytes)
        left_out = np.setdiff1d(times, self._times)
        self._checks = (
            left_out[np.linspace(0, len(left_out) - 1, CHECKS).astype(int)] if len(left_out) else []
        )
        self._offsets: list[list[Offsets | None]] = [[] for _ in range(TEXELS)]
        self._moves = np.zeros(len(model), bool)
        self._ever_seen = np.zeros(len(model), bool)

    def _chosen(self, times: NDArray[np.float64], most_bytes: int) -> NDArray[np.float64]:
        """The times that fit, judged by the texels that move between a few of them."""
        probes = [
            self._model.at(times[place]) for place in {len(times) // 3, len(times) // 2, len(times) - 1}
        ]
        moves = [
            np.abs(_unit_turns(packed(splats), self._first) - self._first) > self._bounds for splats in probes
        ]
        texels = int(np.any(moves, axis=(0, 1)).reshape(TEXELS, 4).any(axis=1).sum())
        fitting = most_bytes // max(8 * texels * len(self._model), 1)
        count = int(min(len(times), max(fitting, 2), MOST_KEYFRAMES))
        return np.ascontiguousarray(times[evenly(range(len(times)), count)])

    @property
    def progress(self) -> float:
        """In [0, 1]."""
        return len(self._offsets[0]) / len(self._times)

    def advance(self, seconds: float) -> bool:
        """Work for about so long. True: all keyframes are there."""
        end = clock.monotonic() + seconds
        while len(self._offsets[0]) < len(self._times):
            self._add(self._times[len(self._offsets[0])])
            if clock.monotonic() > end:
                break
        return len(self._offsets[0]) == len(self._times)

    def _add(self, time: float) -> None:
        splats = self._model.at(time)
        self._ever_seen |= splats.opacities >= ALPHA_CUT
        self._last = _unit_turns(packed(splats), self._last)
        offsets = self._last - self._first
        moves = np.abs(offsets) > self._bounds
        self._moves |= moves.any(axis=1)
        for texel, track in enumerate(self._offsets):
            columns = slice(4 * texel, 4 * texel + 4)
            if moves[:, columns].any():
                track.append(_stored(offsets[:, columns], self._bounds[:, columns]))
            else:
                track.append(None)

    def keyframes(self) -> Keyframes:
        """Once `advance` has said True."""
        moving = np.flatnonzero(self._moves)
        offsets = {}
        for texel, track in enumerate(self._offsets):
            present = [part for part in track if part is not None]
            if present:
                offsets[texel] = _joined(track, moving, np.result_type(*present))
                track.clear()
        rest = unpacked(self._first, self._rest.harmonics)
        done = Keyframes(rest, self._times, moving, offsets, self._ever_seen)
        errors = [_distance(done.at(time), self._model.at(time)) for time in self._checks]
        return replace(done, error=max(errors, default=0.0))


def _unit_turns(records: Float32Array, last: Float32Array | None = None) -> Float32Array:
    """With quaternions of length 1, of the sign that is nearer to those of `last`."""
    quats = records[:, QUAT].astype(np.float64)
    lengths = np.linalg.norm(quats, axis=1, keepdims=True)
    quats = np.where(lengths > 0, quats / np.where(lengths > 0, lengths, 1), [1.0, 0.0, 0.0, 0.0])
    if last is not None:
        quats = of_nearer_sign(quats, last[:, QUAT])
    records[:, QUAT] = quats
    return records


def _stored(offsets: Float32Array, bounds: Float32Array) -> Offsets:
    """As float16 where that is near enough."""
    with np.errstate(over="ignore"):
        short = offsets.astype(np.float16)
    near = np.abs(short.astype(np.float32) - offsets) <= bounds
    return short if near.all() else offsets.copy()


def _joined(track: Sequence[Offsets | None], moving: NDArray[np.int64], dtype: np.dtype[Any]) -> Offsets:
    joined = np.zeros((len(track), len(moving), 4), dtype)
    for place, part in enumerate(track):
        if part is not None:
            joined[place] = part[moving]
    return joined


def _distance(one: Splats, other: Splats) -> float:
    """The greatest between two means."""
    return float(np.linalg.norm(one.means - other.means, axis=1).max(initial=0.0))
