"""A model's values over time, rounded for the page: control values of curves, or samples between which the
page interpolates linearly."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate
from math import inf, sqrt
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.exports.browser.samples import Sampling, sampled
from renderer.deformation.spline_motion import SplineMotion
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from renderer.rotations import of_nearer_sign, unit_quats
from renderer.splats import Float32Array

CUBIC, LINEAR = 3, 1
"""Degrees of what runs through the values."""
ALIGNED: Final = 4
"""Bytes; by so many at once the page reads what it holds."""
ROWS: Final = 2**14
"""Rounded at once, of what may be gigabytes in doubles."""
SAME: Final = 1e-6
"""Below which a value does not move, in its own unit."""
OFF: Final = {"colors": 1 / 128, "quats": 1e-3, "log_scales": 0.01, "opacity_logits": 0.01}
"""By how much rounding may move each of a Gaussian's values, beside its position."""


@dataclass(frozen=True, eq=False)
class Track:
    """(N, K, C) values; K = 1 does not move."""

    name: str
    values: NDArray[Any]
    """Whole numbers of 8 or 16 bits between `low` and `high`; or float32, the values themselves."""
    low: Float32Array
    """(C,)"""
    high: Float32Array
    """(C,)"""

    @classmethod
    def of(cls, name: str, values: Float32Array, bits: int, off: float = inf) -> Track:
        """Rounded over the range of each channel to `bits`, 8 or 16, or to 16 where those move one by more
        than `off`; as they are where these do too, since one stray value makes all others coarse."""
        nothing = np.zeros(values.shape[2], np.float32)
        low, high = (values.min(axis=(0, 1)), values.max(axis=(0, 1))) if len(values) else (nothing, nothing)
        if bits == 8 and _half_step(low, high, 8).max() > off:
            bits = 16
        if _half_step(low, high, bits).max() > off:
            return cls(name, values, nothing, nothing + 1)
        high = np.maximum(high, low + np.float32(1e-9))
        top = (1 << bits) - 1
        # Beside a large value, that is none: what does not vary is then at its lower end.
        span = np.maximum(high.astype(np.float64) - low, np.finfo(np.float64).tiny)
        whole = np.empty(values.shape, np.uint8 if bits == 8 else np.uint16)
        for start in range(0, len(values), ROWS):
            rows = slice(start, start + ROWS)
            share = (values[rows].astype(np.float64) - low) / span
            whole[rows] = np.rint(share * top).clip(0, top)
        return cls(name, whole, low.astype(np.float32), high.astype(np.float32))

    @property
    def rounding(self) -> float:
        """The largest distance between values and what they are rounded to."""
        if self.values.dtype == np.float32:
            return 0.0
        return float(np.linalg.norm(_half_step(self.low, self.high, 8 * self.values.itemsize)))

    def told(self, start: int) -> dict[str, Any]:
        """For the page; `start`: of its bytes among all."""
        count, moments, channels = self.values.shape
        return {
            "name": self.name,
            "start": start,
            "bytes": self.values.itemsize,
            "count": count,
            "moments": moments,
            "channels": channels,
            "low": self.low.tolist(),
            "high": self.high.tolist(),
        }


@dataclass(frozen=True, eq=False)
class Tracks:
    """All of a model: means, colors, quats (unit, wxyz), log_scales and opacity_logits."""

    tracks: tuple[Track, ...]
    degree: int
    """CUBIC: uniform B-splines; LINEAR: through samples at even moments, the first at 0, the last at 1."""
    error: float | None = None
    """Largest distance at a frame between a position of the model and that of the page, in scene units; None:
    not asked for."""

    @property
    def content(self) -> bytes:
        """One after another, each at a multiple of ALIGNED bytes."""
        return b"".join(_padded(track.values.tobytes()) for track in self.tracks)

    def told(self, start: int = 0) -> list[dict[str, Any]]:
        """`start`: of its content among that of others."""
        sizes = (track.values.nbytes for track in self.tracks)
        starts = np.cumsum([start, *(size + -size % ALIGNED for size in sizes)])
        return [track.told(int(start)) for track, start in zip(self.tracks, starts, strict=False)]


def _half_step(low: Float32Array, high: Float32Array, bits: int) -> NDArray[np.float64]:
    return np.asarray((high.astype(np.float64) - low) / ((1 << bits) - 1) / 2)


def _padded(content: bytes) -> bytes:
    return content + bytes(-len(content) % ALIGNED)


def tracks_of(
    model: DynamicGaussians, sampling: Sampling | None = None, rounding: float | None = None
) -> Tracks:
    """Colours by direction are left out: the page shows those that do not depend on it.

    `sampling`: of a motion that is no spline; `rounding`: see BrowserModel.
    """
    motion = model.motion
    if isinstance(motion, SplineMotion):
        tracks, degree, error = _tracks(_of_spline(model.raw, motion), rounding), CUBIC, None
    else:
        samples = sampled(model, sampling)
        tracks, degree, error = _tracks(_over_time(samples.moments), rounding), LINEAR, samples.error
    if rounding is not None:
        error = (error or 0.0) + tracks[0].rounding
    return Tracks(tracks, degree, error)


def _of_spline(raw: RawGaussians, motion: SplineMotion) -> tuple[Float32Array, ...]:
    """Curves of Gaussians and of their nodes are sums of the same basis, so their control values add up."""
    means = _lifted(raw.means, motion.position_controls)
    if len(motion.node_indices):
        shared = motion.node_controls[motion.node_indices]
        if means.shape[1] == 1:
            means = np.repeat(means, motion.n_controls, axis=1)
        means = means + np.einsum("nj,njkc->nkc", motion.node_weights, shared, dtype=np.float64)
    colors = _lifted(raw.colors, motion.color_controls)
    logits = _lifted(raw.opacity_logits[:, None], motion.opacity_controls)
    return means, colors, unit_quats(raw.quats)[:, None], raw.log_scales[:, None], logits


def _lifted(base: Float32Array, controls: Float32Array) -> Float32Array:
    """The weights of a spline sum to 1, so what does not move is added to each control value."""
    return base[:, None] + controls if len(controls) else base[:, None]


def _over_time(samples: Sequence[RawGaussians]) -> tuple[Float32Array, ...]:
    def turns() -> Iterable[Float32Array]:
        every = (unit_quats(one.quats) for one in samples)
        return accumulate(every, lambda before, now: of_nearer_sign(now, before))

    return (
        _stacked(lambda: (one.means for one in samples)),
        _stacked(lambda: (one.colors for one in samples)),
        _stacked(turns),
        _stacked(lambda: (one.log_scales for one in samples)),
        _stacked(lambda: (one.opacity_logits[:, None] for one in samples)),
    )


def _stacked(moments: Callable[[], Iterable[Float32Array]]) -> Float32Array:
    """(N, K, C) of K times (N, C), or the first where nothing moves: whether it does is found without all of
    them in memory."""
    first = next(iter(moments()))
    low, high = first.copy(), first.copy()
    for one in moments():
        np.minimum(low, one, out=low)
        np.maximum(high, one, out=high)
    moves = (high - low).max(initial=0) > SAME
    return np.stack(list(moments()), axis=1) if moves else first[:, None]


def _tracks(values: Iterable[Float32Array], rounding: float | None) -> tuple[Track, ...]:
    """In the order of Tracks. Colours of 8 bits err by up to a few grey levels of each splat, which blending
    and the mean over several control values make less."""
    names = (("means", 16), ("colors", 8), ("quats", 16), ("log_scales", 16), ("opacity_logits", 16))
    off = {} if rounding is None else {"means": rounding / sqrt(3), **OFF}
    return tuple(
        Track.of(name, np.asarray(each, np.float32), bits, off.get(name, inf))
        for (name, bits), each in zip(names, values, strict=True)
    )
