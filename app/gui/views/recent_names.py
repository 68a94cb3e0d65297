"""What recent files are called."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path


def told_apart(paths: Sequence[str]) -> list[str]:
    """Each by its name; by as many of the folders that hold it, too, as tell it from others of that name."""
    every = [Path(path).parts for path in paths]

    def called(own: tuple[str, ...]) -> str:
        same = [other for other in every if other != own]
        ends = (own[-length:] for length in range(1, len(own) + 1))
        alone = (end for end in ends if all(other[-len(end) :] != end for other in same))
        return str(Path(*next(alone, own)))

    return list(map(called, every))
