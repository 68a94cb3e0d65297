"""One way of drawing, as tables of error against run time have it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from renderer.measuring.interleaved_timing import Laps


@dataclass(frozen=True, kw_only=True)
class Row:
    """One setting, drawn."""

    group: str
    setting: str
    mean: float
    """Of the absolute error of the picture over black, in grey levels of 255."""
    p999: float
    """99.9th percentile."""
    most: float
    psnr: float
    """In dB; infinite where nothing differs."""
    milliseconds: float
    """Median of a picture that is drawn anew, to its end."""
    spread: float
    """Half of the distance between the quartiles."""
    entries: int | None = None
    """Of the CPU rasteriser, pairs of a tile and a Gaussian: the work."""
    megabytes: float | None = None
    """Of the keyframes' offsets."""
    baking: float | None = None
    """Of keyframes, in seconds."""

    @classmethod
    def of(cls, group: str, setting: str, errors: NDArray[np.float64], taken: Laps) -> Row:
        """From absolute errors in grey levels, of one picture or several."""
        squared = float(np.square(errors).mean()) / 255**2
        return cls(
            group=group,
            setting=setting,
            mean=float(errors.mean()),
            p999=float(np.quantile(errors, 0.999)),
            most=float(errors.max()),
            psnr=-10 * math.log10(squared) if squared else math.inf,
            milliseconds=1e3 * taken.median,
            spread=1e3 * taken.spread,
        )
