"""Gaussians at rest or at one moment, as training sees them: raw values, whose names carry their space."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from renderer.harmonics import BANDS
from renderer.splats import Float32Array, Splats
from renderer.stored_arrays import Arrays, Stored, check

Floating = TypeVar("Floating", np.float32, np.float64)


def sigmoid(logits: NDArray[Floating]) -> NDArray[Floating]:
    """1 / (1 + exp(-x)) without overflow, of the same type."""
    half = logits.dtype.type(0.5)
    values: NDArray[Floating] = half + half * np.tanh(half * logits)
    return values


def logits(opacities: NDArray[np.floating[Any]]) -> Float32Array:
    """log(a / (1 - a)) of opacities in [0, 1]; infinite at both ends."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(opacities) - np.log1p(-opacities), dtype=np.float32)


@dataclass(frozen=True, eq=False)
class RawGaussians:
    """N Gaussians; or, of the same shapes, gradients by their raw values. All arrays are float32.

    Example:
        >>> import numpy as np
        >>> from renderer import RawGaussians
        >>> raw = RawGaussians(
        ...     means=np.float32([[0, 0, 5], [1, 0, 5]]),
        ...     quats=np.float32([[1, 0, 0, 0]] * 2),
        ...     log_scales=np.log(np.full((2, 3), 0.3, np.float32)),
        ...     opacity_logits=np.float32([0, 2]),
        ...     colors=np.float32([[0.8, 0.2, 0.2], [0.2, 0.8, 0.2]]),
        ...     harmonics=np.zeros((2, 0, 3), np.float32),
        ... )
        >>> raw.splats().scales.shape, float(raw.splats().opacities[0])
        ((2, 3), 0.5)
    """

    means: Float32Array
    """(N, 3) in the clip's unit."""
    quats: Float32Array
    """(N, 4) wxyz, not normalised."""
    log_scales: Float32Array
    """(N, 3) natural logarithm of the standard deviations."""
    opacity_logits: Float32Array
    """(N,)"""
    colors: Float32Array
    """(N, 3) RGB, the part that does not depend on the view."""
    harmonics: Float32Array
    """(N, B, 3) spherical harmonics of degree 1 and above, B = 0, 3, 8 or 15; see harmonics.py."""

    def __len__(self) -> int:
        return len(self.means)

    def splats(self) -> Splats:
        """Activated."""
        return Splats(
            means=self.means,
            quats=self.quats,
            scales=np.exp(self.log_scales),
            opacities=sigmoid(self.opacity_logits),
            colors=self.colors,
            harmonics=self.harmonics,
        )

    def rows(self, index: NDArray[np.int64]) -> RawGaussians:
        """The chosen Gaussians in the order of `index`, which may repeat some."""
        # Several times as fast as an index in brackets.
        return RawGaussians(**{name: value.take(index, axis=0) for name, value in self.arrays().items()})

    def of_degree(self, degree: int) -> RawGaussians:
        """With the harmonics of so high a degree, those that it has none of 0.

        Raises:
            ValueError: colours depend on the direction to a higher degree.
        """
        bands, own = BANDS[degree], self.harmonics.shape[1]
        if self.harmonics[:, bands:].any():
            raise ValueError(f"degree {BANDS.index(own)} of colours that depend on the direction")
        kept = self.harmonics[:, :bands]
        padded = np.pad(kept, ((0, 0), (0, bands - kept.shape[1]), (0, 0)))
        return replace(self, harmonics=padded)

    def arrays(self) -> Arrays:
        """Every array by field name, in a fixed order."""
        return {name: getattr(self, name) for name in FIELDS}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> RawGaussians:
        """Takes its own of many arrays; files of old have no harmonics."""
        own = {name: arrays[name] for name in FIELDS if name in arrays}
        own.setdefault("harmonics", np.zeros((len(own["means"]), 0, 3), np.float32))
        return cls(**own)

    @classmethod
    def check(cls, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Raises ValueError when an array of a file is missing, or is not what it must be."""
        lengths: dict[str, int] = {}
        check(arrays, LAYOUT, lengths)
        if lengths.get("B", 0) not in BANDS:
            raise ValueError(f"expected harmonics of {BANDS} functions, got {lengths['B']}")


def joined(parts: Sequence[RawGaussians]) -> RawGaussians:
    """One after the other, one at least; colours depend on the direction to the highest degree of them."""
    if len(parts) == 1:
        return parts[0]
    degree = max(BANDS.index(part.harmonics.shape[1]) for part in parts)
    arrays = [part.of_degree(degree).arrays() for part in parts]
    return RawGaussians(**{name: np.concatenate([each[name] for each in arrays]) for name in FIELDS})


FIELDS = tuple(item.name for item in fields(RawGaussians))
LAYOUT = {
    "means": Stored("N 3"),
    "quats": Stored("N 4"),
    "log_scales": Stored("N 3"),
    "opacity_logits": Stored("N"),
    "colors": Stored("N 3"),
    "harmonics": Stored("N B 3", optional=True),
}
