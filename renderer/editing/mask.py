"""A set of a model's Gaussians, one bit each: a small value that can be compared, kept and written."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Mask:
    """Some of `count` Gaussians.

    Raises:
        ValueError: bits beyond `count`, or two masks of different counts in one operation.
    """

    count: int
    bits: int = 0
    """Bit n stands for Gaussian n: Python's integers combine half a million of them in microseconds."""

    def __post_init__(self) -> None:
        if self.bits < 0 or self.bits.bit_length() > self.count:
            raise ValueError(f"expected a mask of {self.count} Gaussians, got bits of others")

    @classmethod
    def of(cls, chosen: NDArray[np.bool_]) -> Mask:
        """From (N,) booleans."""
        return cls.unpacked(len(chosen), np.packbits(chosen, bitorder="little").tobytes())

    @classmethod
    def all(cls, count: int) -> Mask:
        return cls(count, (1 << count) - 1)

    @classmethod
    def unpacked(cls, count: int, packed: bytes) -> Mask:
        """What `packed` gave. Raises ValueError for another count."""
        return cls(count, int.from_bytes(packed, "little"))

    def packed(self) -> bytes:
        """Eight Gaussians a byte, the first in the lowest bit."""
        return self.bits.to_bytes(-(-self.count // 8), "little")

    def booleans(self) -> NDArray[np.bool_]:
        """(N,)"""
        packed = np.frombuffer(self.packed(), np.uint8)
        return np.unpackbits(packed, count=self.count, bitorder="little").view(np.bool_)

    def indices(self) -> NDArray[np.int64]:
        """Of the chosen ones, rising."""
        return np.flatnonzero(self.booleans())

    def __len__(self) -> int:
        """How many are chosen."""
        return self.bits.bit_count()

    def __or__(self, other: Mask) -> Mask:
        return Mask(self._agreed(other), self.bits | other.bits)

    def __and__(self, other: Mask) -> Mask:
        return Mask(self._agreed(other), self.bits & other.bits)

    def __sub__(self, other: Mask) -> Mask:
        return Mask(self._agreed(other), self.bits & ~other.bits)

    def __invert__(self) -> Mask:
        return Mask.all(self.count) - self

    def _agreed(self, other: Mask) -> int:
        if self.count != other.count:
            raise ValueError(f"expected masks of one model, got {self.count} and {other.count} Gaussians")
        return self.count
