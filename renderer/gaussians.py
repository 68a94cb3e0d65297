"""Dynamic Gaussians: raw values and what moves them, for files, training and drawing. Numpy only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from renderer.deformation.fdm import FlexibleMotion
from renderer.deformation.hexplane_motion import HexplaneMotion
from renderer.deformation.motion import Motion, Still
from renderer.deformation.spline_motion import SplineMotion
from renderer.raw_gaussians import Arrays, RawGaussians
from renderer.splats import Float32Array, Splats

MOTIONS: tuple[type[Motion], ...] = (SplineMotion, FlexibleMotion, HexplaneMotion)
"""Each is known in a file by the names of its arrays."""
NEEDED = ("means", "quats", "log_scales", "opacity_logits", "colors")


@dataclass(frozen=True, eq=False)
class DynamicGaussians:
    """N Gaussians that move and change over time in [0, 1]."""

    raw: RawGaussians
    """At rest."""
    motion: Motion

    def __len__(self) -> int:
        return len(self.raw)

    @property
    def means(self) -> Float32Array:
        """(N, 3) positions at rest, in the clip's unit."""
        return self.raw.means

    def at(self, time: float) -> Splats:
        """The activated splats at `time` in [0, 1]."""
        return self.motion.moved(self.raw, time).splats()

    def rows(self, index: NDArray[np.int64]) -> Self:
        """The chosen Gaussians with their motion."""
        return type(self)(self.raw.rows(index), self.motion.rows(index))

    def arrays(self) -> Arrays:
        """Every array by name, in a fixed order."""
        return self.raw.arrays() | self.motion.arrays()

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """What `arrays` gave. Raises ValueError when an array is missing."""
        missing = [name for name in NEEDED if name not in arrays]
        if missing:
            raise ValueError(f"expected a VesselSplat model with {', '.join(missing)}")
        for kind in MOTIONS:
            if kind.NAMES[-1] in arrays:
                return cls(RawGaussians.from_arrays(arrays), kind.from_arrays(arrays))
        return cls(RawGaussians.from_arrays(arrays), Still())

    def save(self, path: Path, metadata: dict[str, str] | None = None) -> None:
        arrays = {name: np.ascontiguousarray(value) for name, value in self.arrays().items()}
        path.write_bytes(save(arrays, metadata))

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read what `save` wrote. Raises ValueError for a file that is no such model."""
        try:
            with safe_open(path, framework="numpy") as file:
                arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        except (SafetensorError, OSError) as error:
            raise ValueError(f"expected a model in safetensors format, got {error}: {path}") from error
        try:
            return cls.from_arrays(arrays)
        except (ValueError, KeyError) as error:
            raise ValueError(f"{error}: {path}") from error
