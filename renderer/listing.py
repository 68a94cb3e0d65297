"""Names and numbers in a sentence."""

from __future__ import annotations

from collections.abc import Sequence

_LISTED = 5


def listed(names: Sequence[str]) -> str:
    """The first few names, and how many more there are."""
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return ", ".join(names[:_LISTED]) + more


def count(number: int, one: str) -> str:
    """1 frame, 2 frames."""
    return f"{number} {one}" if number == 1 else f"{number} {one}s"
