"""A frame that the search for poses could not place."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LostFrame:
    """A frame without a pose of its own."""

    frame: int
    """From 0."""
    why: str
