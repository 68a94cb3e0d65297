"""How much one file may ask for, before it is decoded: a small one can claim gigabytes, or hours."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Final

PREFIX: Final = "VESSELSPLAT_MOST_"
"""Of the variables of the environment that change a limit: VESSELSPLAT_MOST_PIXELS and so on."""


class OverBudget(ValueError):
    """A file asks for more than a limit: the text says which, and how to change it."""


@dataclass(frozen=True)
class Budget:
    """Limits far above what endoscopes and their reconstructions need."""

    pixels: int = 80_000_000
    """Of one picture or frame; 8K has 33 million."""
    splats: int = 5_000_000
    """Of one packed file, and of a model; our own have 30,000."""
    frames: int = 200_000
    """Of a clip or run: an hour at 50 a second has 180,000."""
    seconds: int = 3600
    """Of a camera path."""

    def require(self, **asked: float) -> None:
        """Raises OverBudget where one of these is asked for more of."""
        for name, amount in asked.items():
            most = getattr(self, name)
            if not amount <= most:
                limit = f"expected at most {most} {name} ({_variable(name)} sets the limit)"
                raise OverBudget(f"{limit}, got {amount:.15g}")


def budget() -> Budget:
    """The limits, or what the environment says in whole numbers instead. Raises OverBudget: not a number."""
    return Budget(**{name: _told(name, own) for name, own in vars(Budget()).items()})


def _told(name: str, own: int) -> int:
    said = os.environ.get(_variable(name), "")
    if not said:
        return own
    if not said.isascii() or not said.isdigit():
        raise OverBudget(f"expected a whole number in {_variable(name)}, got {said}")
    return int(said)


def _variable(name: str) -> str:
    return PREFIX + name.upper()
