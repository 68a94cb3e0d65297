"""Brightness and colour as sliders show them, more to the right; files and commands keep z and d."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

MOST_D, LEAST_D = 4.0, 0.01
"""Of d-factors that are not 0; a smaller one gives what LEAST_D gives."""
FAINTEST = 1 / (1 + MOST_D)
"""The amount of colour of MOST_D, the least that is not 0."""


def brightness_of(z: float) -> float:
    """How much Eq 1 lifts dark areas: 0 leaves brightness unchanged."""
    return round(1 - z, 6)


def z_of(brightness: float) -> float:
    return round(1 - brightness, 6)


def color_of(d_factor: float) -> float:
    """The saturation that Eqs 11 and 12 give to what they leave at 0.5 with the paper's d; 0: unchanged.

    S* = A S^2 / (A S^2 + k B (1 - S)^2) is 1 / (1 + k) there, so equal steps change colours about equally,
    and the paper's k = 1 is in the middle.
    """
    return 0.0 if d_factor == 0 else 1 / (1 + d_factor)


def d_factor_of(color: float) -> float:
    """The nearest that there is: up to FAINTEST, that or no change at all; in steps that can be read."""
    if color < FAINTEST / 2:
        return 0.0
    return round(min(max(1 / color - 1, LEAST_D), MOST_D), 2)


@dataclass(frozen=True)
class Amount:
    """How a slider shows a parameter."""

    lo: float
    hi: float
    text: str
    of_parameter: Callable[[float], float] = float
    to_parameter: Callable[[float], float] = float
    symbol: str = ""
    equation: str = ""

    def explained(self, parameter: float | None) -> str:
        """What it does, and its value in the paper's sense."""
        if not self.symbol or parameter is None:
            return self.text
        return f"{self.text} Now {self.symbol} {parameter:.2f} in {self.equation}."


def spaced(name: str, first: float, last: float, count: int) -> tuple[float, ...] | None:
    """So many values of a parameter, whose amounts are evenly spaced; None for one without amounts."""
    if (shown := AMOUNTS.get(name)) is None:
        return None
    ends = shown.of_parameter(first), shown.of_parameter(last)
    step = (ends[1] - ends[0]) / max(count - 1, 1)
    values = (shown.to_parameter(round(ends[0] + place * step, 6)) for place in range(count))
    return tuple(dict.fromkeys(values))


AMOUNTS: Final[Mapping[str, Amount]] = {
    "z": Amount(
        0.0,
        1.0,
        "How much dark areas are brightened: 0 leaves brightness unchanged, 1 lifts most.",
        brightness_of,
        z_of,
        "z",
        "Eq 1",
    ),
    "d_factor": Amount(
        0.0,
        1.0,
        f"How much colour: 0 leaves saturation unchanged. Otherwise from {FAINTEST:.1f}, pale, through 0.5, "
        "the paper's, to 1.",
        color_of,
        d_factor_of,
        "d-factor",
        "Eq 11",
    ),
}
"""Of the parameters that fall where what they do rises."""
