"""How red an image is, and so how far what darkens its vessels has the colour of blood."""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

SAMPLES: Final = 1024
"""Evenly spread places at least that tell, where there are so many."""
CLIPPED: Final = 250 / 255
"""From here on red and green may be cut off: where both are, nothing tells how much redder it was."""
Bounds = tuple[float, float]
GREY: Final[Bounds] = (0.0, 0.15)
"""Natural logarithm of red over green: up to the first a place is grey, from the second on it is not."""
TINGED: Final[Bounds] = (0.12, 0.2)
"""The same of what is grey but for red light from around, as metal beside tissue: at .2, vessels of white
tissue begin (on training frames and the half that `visibility_front` calls chosen)."""
PALE_IMAGE, RED_IMAGE = 0.18, 0.26
"""Redness of an image, up to which vessels may be as pale as such metal, and from which on they are not."""


class Reds(NamedTuple):
    """Sums over pixels, of [0, 1] each."""

    red: float
    """What red exceeds green by; noise of colour, of either sign, cancels out."""
    light: float
    """V."""

    @property
    def share(self) -> float | None:
        """The redness: some 0.2 to 0.7 of tissue in white light, about 0 where all is grey. None: no pixel is
        known, or all are black or clipped."""
        return self.red / self.light if self.light > 0 else None


NO_REDS: Final = Reds(0.0, 0.0)


def reds(pixels: NDArray[Any], keep: NDArray[np.uint8], spans: NDArray[np.int32], full: int) -> Reds:
    """Of an image as `Shown` has it, but for what is clipped; each sample for as many pixels as there are."""
    step = max(1, math.isqrt(pixels.shape[0] * pixels.shape[1] // SAMPLES))
    red, light = _sums(pixels, keep, spans, step, CLIPPED * full)
    return Reds(red * step * step / full, light * step * step / full)


@njit(cache=True, error_model="numpy")
def _sums(
    pixels: NDArray[Any],  # (H, W, 3)
    keep: NDArray[np.uint8],  # (H, W) 0 or 1, or empty: all
    spans: NDArray[np.int32],  # (H, 2) of `FieldOfView.spans`, or empty: all
    step: int,
    clipped: float,
) -> tuple[float, float]:
    """Of every so many pixels down and across."""
    red, light = 0.0, 0.0
    for y in range(0, pixels.shape[0], step):
        first, end = (spans[y, 0], spans[y, 1]) if len(spans) > 0 else (0, pixels.shape[1])
        for x in range(0, pixels.shape[1], step):
            if first <= x < end and (len(keep) == 0 or keep[y, x] > 0):
                one = np.float64(pixels[y, x, 0]), np.float64(pixels[y, x, 1]), np.float64(pixels[y, x, 2])
                if min(one[0], one[1]) < clipped:
                    red += one[0] - one[1]
                    light += max(one)
    return red, light


def blood_share(redness: float | None, least: float) -> float:
    """Of the colour of blood in what darkens vessels, in [0, 1]: all of it from a redness of `least` on, none
    up to half of that, where hues stay; all of it also where redness is not known."""
    if redness is None or least == 0:
        return 1.0
    return min(max(2 * redness / least - 1, 0.0), 1.0)


def grey_of(redness: float, tinged: float) -> Bounds:
    """What is grey in an image so red: GREY, or by `tinged`, in [0, 1], up to TINGED where it is red."""
    share = tinged * min(max((redness - PALE_IMAGE) / (RED_IMAGE - PALE_IMAGE), 0.0), 1.0)
    low, high = (grey + share * (other - grey) for grey, other in zip(GREY, TINGED, strict=True))
    return low, high
