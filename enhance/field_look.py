"""What a small copy of the picture tells at once: the colour of its corners, its tones, and what is lit."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enhance.field_even import ALIKE, corners_of
from enhance.field_outline import Lit, Outline, lit_in, sharp_from
from enhance.field_regions import Levels, Runs
from enhance.field_tones import Tones, tones_in

NO_COLORS: Final = np.empty((0, 0, 3), np.uint8)
"""Of a copy that has been looked at in another way."""


class Look(NamedTuple):
    """At a small copy."""

    surround: NDArray[np.int16] | None
    """The colour, (3,) or (1,) in grey levels, that the corners have; None: they are of several, or black, in
    which V tells the field."""
    tones: Tones | None = None
    """Of a dark surround; None: no corner can be one."""
    lit: Lit | None = None
    """What is not that surround."""
    outline: Outline | None = None
    """Of what is lit; None: too dark to tell."""


def look_at(low: Levels, colors: Levels = NO_COLORS) -> Look:
    """low: (h, w) V without specks; colors: (h, w, 3) or (h, w), of which a surround may have one."""
    channels = colors if colors.ndim == 3 else colors[..., None]
    is_even, color, is_dark, tones, lit, is_told, outline = _look(channels, low)
    if is_even:
        return Look(color)
    if not is_dark:
        return Look(None)
    sharp = sharp_from(tones.threshold)
    return Look(None, tones, Lit(tones.threshold, sharp, *lit), outline if is_told else None)


@njit(cache=True, error_model="numpy")
def _look(
    colors: Levels, low: Levels
) -> tuple[
    bool,
    NDArray[np.int16],
    bool,
    Tones,
    tuple[Levels, Runs, NDArray[np.int64]],
    bool,
    Outline,
]:
    """Whether the corners have one colour, and that; `tones_in`; and `lit_in`, if these tell a surround."""
    color, alike = corners_of(colors)
    is_even = alike >= ALIKE
    is_dark, tones = (False, Tones(0.0, 0.0, 0.0, 0.0, 0.0, False)) if is_even else tones_in(low)
    if not is_dark:
        no_parts = np.empty((0, 2), np.int32), np.empty(0, np.int32), np.empty(0, np.int32)
        nothing = np.empty((0, 0), np.uint8), no_parts, np.empty(0, np.int64)
        return is_even, color, False, tones, nothing, False, Outline(np.empty((0, 2)), False, False)
    lit, is_told, outline = lit_in(low, tones.threshold, sharp_from(tones.threshold))
    return is_even, color, True, tones, lit, is_told, outline
