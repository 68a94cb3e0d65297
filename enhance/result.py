"""What comes out of the enhancement."""

from __future__ import annotations

from dataclasses import dataclass

from enhance.image import AnyImage
from enhance.statistics import Statistics


@dataclass(frozen=True)
class Omission:
    """One stage that this image does not need and that is therefore left out."""

    what: str
    why: str
    error: float
    """Bound on the difference that it makes, in grey levels of the result."""


@dataclass(frozen=True, eq=False)
class EnhanceResult:
    """An enhanced image and all that is needed to repeat it."""

    image: AnyImage
    """Shape and type of the input."""
    statistics: Statistics
    """What was used."""
    omitted: tuple[Omission, ...]
