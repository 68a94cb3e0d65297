"""Local detail (Eqs 7-10): darker than its surround gets darker, brighter gets brighter."""

from __future__ import annotations

from typing import Final

from enhance.params import PForm

FLOOR: Final = 1 / 255
"""Added to Q and to V: a ratio of blacks is 1. A floor under V alone turns black white."""


def exponent(sigma: float, form: PForm) -> float:
    """P of Eq 9.

    Args:
        sigma: standard deviation of Q in grey levels, 0 to 127.5.
        form: "literal" jumps by 0.02 at sigma = 2 and by 0.04 at 10, as printed; "continuous" follows the
            middle branch from 7/4 (at 2.125) to 1/2 (at 10.25).
    """
    middle = (27 - 2 * sigma) / 13
    if form == "continuous":
        return min(max(middle, 0.5), 1.75)
    if sigma <= 2:
        return 1.75
    return middle if sigma < 10 else 0.5
