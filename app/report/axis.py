"""Numbers on logarithmic axes, on the page and in the window."""

from __future__ import annotations

from typing import Final

TICKS: Final = {6: (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0), 300: (1.0, 2.0, 5.0)}


def of_a_decade(least: float, most: float) -> tuple[float, ...]:
    """More numbers the fewer decades an axis has."""
    span = most / least if least > 0 else float("inf")
    return next((digits for ratio, digits in TICKS.items() if span < ratio), (1.0,))
