"""What an attack finds, and the shape that every attack has."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Failure:
    """Of one file, session or process."""

    reader: str
    """What was attacked."""
    number: int
    """That makes it again."""
    error: str


Attack = Callable[[Path, int], tuple[int, list[Failure]]]
"""From a folder of valid files and a count to how many attacks there were, and what failed."""
