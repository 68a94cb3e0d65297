"""What moves Gaussians over a clip: every deformation has this face, for training, drawing and files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from renderer.raw_gaussians import RawGaussians
from renderer.stored_arrays import Arrays


class Motion(Protocol):
    """A function of time; a value, whose arrays training changes in place."""

    NAMES: ClassVar[tuple[str, ...]]
    """Of its arrays, as files have them."""

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        """The Gaussians that there are at `time` in [0, 1]; arrays that do not move are those of `raw`
        themselves. Raises ValueError: it moves another number of Gaussians."""
        ...

    def rows(self, index: NDArray[np.int64]) -> Self:
        """The motion of the chosen Gaussians."""
        ...

    def arrays(self) -> Mapping[str, NDArray[Any]]: ...

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Takes its own of many arrays."""
        ...

    @classmethod
    def check(cls, arrays: Mapping[str, NDArray[Any]], count: int) -> None:
        """Raises ValueError where arrays of a file would not move `count` Gaussians."""
        ...


@dataclass(frozen=True)
class Still:
    """Nothing moves."""

    NAMES: ClassVar[tuple[str, ...]] = ()

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        return raw

    def rows(self, index: NDArray[np.int64]) -> Still:
        return self

    def arrays(self) -> Arrays:
        return {}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Still:
        return cls()

    @classmethod
    def check(cls, arrays: Mapping[str, NDArray[Any]], count: int) -> None:
        """See Motion."""
