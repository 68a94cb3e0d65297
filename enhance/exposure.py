"""Exposure: underexposed images are brightened first of all, as much as their bright end asks for."""

from __future__ import annotations

from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from enhance.brightness import level

Float = TypeVar("Float", bound=np.floating[Any])

TENTHS: Final = 9
"""Of the pixels, that are no brighter than the bright end: reflections and letters are in the last."""
BRIGHT: Final = 96.0
"""Grey levels that the bright end has at least; of frames that are exposed well it has some 150 to 250."""
NOTHING: Final = 4.0
"""Grey levels: the bright end of what a covered lens shows, which is noise."""


def bright_level(cumulative: NDArray[np.int64]) -> int:
    """The smallest grey level where the cumulative histogram of V reaches 0.9."""
    return level(cumulative, TENTHS)


def exposure(bright: float | None, most: float) -> float:
    """How many times brighter the dark tones become, from 1 to `most`, so that the bright end becomes BRIGHT;
    1 where it is at least that, is no more than NOTHING, or is not known.

    Args:
        bright: `bright_level`, in grey levels, 0 to 255.
    """
    if bright is None or bright <= NOTHING:
        return 1.0
    wanted = BRIGHT / (255 - BRIGHT) * (255 - bright) / bright
    return max(1.0, min(wanted, bright / NOTHING, most))


def exposed(value: NDArray[Float], times: float) -> NDArray[Float]:
    """V, in [0, 1], brighter: black and white stay, the slope at black is `times`; exactly V at 1."""
    return np.asarray(times * value / (1 + (times - 1) * value), dtype=value.dtype)
