"""How many triangles a surface has. Apart from what makes it, which takes seconds to load at first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

VERTICES: Final = 20_000
"""Of a picture full of tissue, without a wish for another number."""


@dataclass(frozen=True)
class Fineness:
    """How many triangles."""

    vertices: int = VERTICES
    """About, before simplifying; the distance between two is the same over the picture."""
    faces: int | None = None
    """At most, by simplifying; None: as they come."""


AS_IT_COMES: Final = Fineness()
