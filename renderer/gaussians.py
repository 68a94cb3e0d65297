"""Dynamic Gaussians: raw values and what moves them, for files, training and drawing. Numpy only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from renderer.atomic_files import written_atomically
from renderer.deformation.kinds import motion_among
from renderer.deformation.motion import Motion
from renderer.deformation.windowed_motion import WindowedMotion
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Float32Array, Splats
from renderer.stored_arrays import LazyArrays, read_arrays, stored_arrays, write_arrays

ROUNDING = 1e-6
"""By which a time may miss [0, 1]."""
NEEDED = ("means", "quats", "log_scales", "opacity_logits", "colors")


@dataclass(frozen=True, eq=False)
class DynamicGaussians:
    """N Gaussians that move and change over time in [0, 1]: what training gives; safetensors as a file.

    Example:
        >>> import numpy as np
        >>> from renderer import DynamicGaussians, RawGaussians
        >>> raw = RawGaussians(
        ...     means=np.float32([[0, 0, 5], [1, 0, 5]]),
        ...     quats=np.float32([[1, 0, 0, 0]] * 2),
        ...     log_scales=np.log(np.full((2, 3), 0.3, np.float32)),
        ...     opacity_logits=np.float32([0, 2]),
        ...     colors=np.float32([[0.8, 0.2, 0.2], [0.2, 0.8, 0.2]]),
        ...     harmonics=np.zeros((2, 0, 3), np.float32),
        ... )
        >>> from renderer.deformation.motion import Still
        >>> model = DynamicGaussians(raw, Still())
        >>> model.at(0.5).opacities.round(2).tolist()
        [0.5, 0.8799999952316284]
    """

    raw: RawGaussians
    """At rest."""
    motion: Motion

    def __len__(self) -> int:
        return len(self.raw)

    @property
    def means(self) -> Float32Array:
        """(N, 3) positions at rest, in the clip's unit."""
        return self.raw.means

    @property
    def n_bytes(self) -> int:
        """Of all arrays."""
        return sum(value.nbytes for value in self.arrays().values())

    def at(self, time: float) -> Splats:
        """The activated splats at `time` in [0, 1], to be read: what does not move is the model's own memory.

        Raises:
            ValueError: another time, NaN among them, or a motion of another number of Gaussians.
        """
        if not -ROUNDING <= time <= 1 + ROUNDING:
            raise ValueError(f"expected a time in [0, 1], got {time}")
        return self.motion.moved(self.raw, time).splats()

    def rows(self, index: NDArray[np.int64]) -> Self:
        """The chosen Gaussians with their motion: whole numbers, also from the end, or (N,) bool.

        Raises:
            ValueError: of a model in windows, an index that is not in their order.
        """
        index = np.arange(len(self))[index]
        return type(self)(self.raw.rows(index), self.motion.rows(index))

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """Every array by name, in a fixed order; those of windows are read as they are asked for."""
        own, of_motion = self.raw.arrays(), self.motion.arrays()
        if isinstance(of_motion, dict):
            return own | of_motion
        return LazyArrays([*own, *of_motion], lambda name: own[name] if name in own else of_motion[name])

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """What `arrays` gave in this process or its child: nothing is checked."""
        return cls(RawGaussians.from_arrays(arrays), _motion_of(arrays).from_arrays(arrays))

    @classmethod
    def checked(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """What a file gave. Raises ValueError when an array is missing, or is not what it must be."""
        missing = [name for name in NEEDED if name not in arrays]
        if missing:
            raise ValueError(f"expected a VesselSplat model with {', '.join(missing)}")
        RawGaussians.check(arrays)
        _motion_of(arrays).check(arrays, len(arrays["means"]))
        return cls.from_arrays(arrays)

    def save(self, path: str | Path, metadata: dict[str, str] | None = None) -> None:
        """Into a file that appears when it is complete.

        Raises:
            ValueError: `load` would refuse it.
            OSError: it cannot be written.
        """
        arrays = self.arrays()
        if isinstance(arrays, dict):  # Those of windows were checked when they were read, or written.
            arrays = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
            self.checked(arrays)
        with written_atomically(Path(path)) as partial:
            write_arrays(partial, arrays, metadata)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read what `save` wrote. Raises ValueError for a file that is no such model."""
        path = Path(path)
        stored = stored_arrays(path)
        in_windows = _motion_of(stored) is WindowedMotion
        try:
            return cls.checked(stored if in_windows else read_arrays(path)[0])
        except ValueError as error:
            raise ValueError(f"{error}: {path}") from error


def _motion_of(arrays: Mapping[str, NDArray[Any]]) -> type[Motion]:
    return WindowedMotion if WindowedMotion.NAMES[-1] in arrays else motion_among(arrays)
