"""The second pass of the preset `vessel`: brightness and colour, then the attenuation by blood.

All in one go, from the chunk that is read to the one written. Sums are never reordered, so results repeat
bit for bit.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance import vessel_curves
from enhance.calm_color import calm
from enhance.part import part
from enhance.pixel_block import (
    BLUE,
    CHUNK,
    GREEN,
    LEAST_COLOR,
    ONE,
    RED,
    TOTAL,
    TWO,
    VALUE,
    ZERO,
    copy_pixels,
    zero_chunk,
)
from enhance.powers import LOG2_E, brief_exp2, brief_log2
from enhance.prefetch import fetch
from enhance.recolor import BLACK, faded_to_black, store
from enhance.rows import REACH, ROWS, held_width, read_row
from enhance.upscale import bring_up
from enhance.vessel_curves import faded, unpacked, value_of
from enhance.vessel_first_pass import SUBSAMPLE, TASK
from enhance.wide_vectors import wide_vectors

ABSORPTION: Final = np.array([0.15, 1.0, 0.8], dtype=np.float32)
"""Of haemoglobin in the red, green and blue of a camera, relative to green (coarse: sensors differ)."""
TWENTY = np.float32(20.0)
LOWEST, DIM = np.float32(vessel_curves.LOWEST), np.float32(vessel_curves.DIM)
TINY = np.float32(1e-6)
LEAST_SQUARE = np.float32(1e-12)


@njit(parallel=True, nogil=True, cache=True, fastmath={"contract"}, error_model="numpy")
def second_pass(
    image: NDArray[Any],  # (H, W, 3)
    spans: NDArray[np.int32],  # (H, 2) of `FieldOfView.spans`, or empty: all; outside, `image` stays
    around: NDArray[np.float32],  # (3, h, w) of `calm_blotches.colors_around`, or empty
    smoothing: np.float32,  # how much of coarse noise of colour goes
    full: np.float32,  # the image's value of 1.0
    sums_type: NDArray[Any],  # `sums_of` the image
    brightness: NDArray[np.float32],  # of Vn by log2 V, see `vessel_curves`
    exposure: np.float32,  # of which that is: what counts as black is so many times darker
    density: NDArray[np.float32],  # (1, h, w) of blood, in [0, `vessel_density.BOUND`]
    powers: NDArray[np.float32],  # of V^gamma by V
    pull: np.float32,  # k B / A of Eq 11; negative: S stays
    most_color: np.float32,  # bound on the gain of S
    strength: np.float32,
    share: np.float32,  # of the light in which blood has its colour; in the rest, all three lose all
    out: NDArray[Any],  # (H, W, 3), out, of the image's type
) -> None:
    """See `enhance.vessel.enhance_vessels`."""
    rows, width = image.shape[0], held_width(image.shape[1])
    rise = exposure * (ONE / BLACK)
    for task in prange((rows + TASK - 1) // TASK):
        _render_task(
            task,
            image,
            spans,
            around,
            smoothing,
            full,
            brightness,
            rise,
            density,
            powers,
            pull,
            most_color,
            strength,
            share,
            out,
            np.empty((2, 3, width if smoothing > ZERO else 0), np.float32),
            np.full(2, -1),
            np.empty((2, CHUNK), np.float32),
            np.zeros((ROWS, 3, width), image.dtype),
            np.zeros((ROWS, 3, width), sums_type.dtype),
            np.zeros((3, CHUNK), image.dtype),
            np.zeros((3, CHUNK), sums_type.dtype),
            zero_chunk(),  # type: ignore[call-arg]
            np.zeros((2, 1, width + SUBSAMPLE), np.float32),
            np.full(2, -1),
        )


@part(forceinline=True, fastmath={"contract"})
def _render_task(
    task: int,
    image: NDArray[Any],
    spans: NDArray[np.int32],
    around: NDArray[np.float32],
    smoothing: np.float32,
    full: np.float32,
    brightness: NDArray[np.float32],
    rise: np.float32,
    density: NDArray[np.float32],
    powers: NDArray[np.float32],
    pull: np.float32,
    most_color: np.float32,
    strength: np.float32,
    share: np.float32,
    out: NDArray[Any],
    colors: NDArray[np.float32],
    held_colors: NDArray[np.int64],
    work: NDArray[np.float32],
    lines: NDArray[Any],
    across: NDArray[Any],
    apart: NDArray[Any],
    narrow: NDArray[Any],
    chunk: NDArray[np.float32],
    blood: NDArray[np.float32],
    held: NDArray[np.int64],
) -> None:
    """A task's rows; after `out` comes memory to work in."""
    rows, columns = image.shape[0], image.shape[1]
    unit = ONE / full
    top, bottom = task * TASK, min((task + 1) * TASK, rows)
    for y in range(top - REACH, top + REACH):
        read_row(image, y, spans, full, around, smoothing, colors, held_colors, work, lines, across)
    for y in range(top, bottom):
        read_row(image, y + REACH, spans, full, around, smoothing, colors, held_colors, work, lines, across)
        first, end = (spans[y, 0], spans[y, 1]) if len(spans) > 0 else (0, columns)
        weight = bring_up(density, y, SUBSAMPLE, blood, held)
        for x0 in range(first // CHUNK * CHUNK, end if end > first else 0, CHUNK):
            count = min(CHUNK, columns - x0)
            fetch(image, y + REACH + 1, x0)
            fetch(out, y, x0 + CHUNK)
            calm(lines, across, y, x0, unit, narrow, chunk)
            _brighten(chunk, brightness)
            even, odd = blood[0, 0, x0:], blood[1, 0, x0:]
            if share < ONE:
                _finish(chunk, rise, powers, pull, most_color, even, odd, weight, strength, share, full)
            else:  # As a constant, it costs nothing.
                _finish(chunk, rise, powers, pull, most_color, even, odd, weight, strength, ONE, full)
            store(chunk, full, apart, out[y, x0 : x0 + count])
        copy_pixels(image[y, :first], out[y, :first])
        copy_pixels(image[y, end:], out[y, end:])


@part(forceinline=True, fastmath={"contract"})
def _brighten(chunk: NDArray[np.float32], brightness: NDArray[np.float32]) -> None:
    """Vn of Eq 1 from VALUE, into TOTAL."""
    wide_vectors()
    terms = unpacked(brightness)
    for i in range(CHUNK):
        log = brief_log2(chunk[VALUE, i])
        chunk[TOTAL, i] = value_of(terms, (log if log > LOWEST else LOWEST) * (-TWO / LOWEST) + ONE)


@part(forceinline=True, fastmath={"contract"})
def _finish(
    chunk: NDArray[np.float32],
    rise: np.float32,
    powers: NDArray[np.float32],
    pull: np.float32,
    most_color: np.float32,
    even: NDArray[np.float32],  # rows of the density on either side
    odd: NDArray[np.float32],
    weight: np.float32,
    strength: np.float32,
    share: np.float32,
    full: np.float32,
) -> None:
    """Colours of Vn and the gain of S, less what blood takes, times the value that means 1.0.

    ABSORPTION in twentieths is whole, so powers of one exponential serve for three.
    """
    wide_vectors()
    terms = unpacked(powers)
    taken, rest = -LOG2_E / TWENTY * strength, ONE - share
    for i in range(CHUNK):
        value = chunk[VALUE, i]
        bright = _deepened(chunk[TOTAL, i], value, rise, terms)
        fall = bright * _color_gain(value, chunk[LEAST_COLOR, i], pull, most_color)
        power = brief_exp2(taken * (even[i] + weight * (odd[i] - even[i])))
        second = power * power
        fourth = second * second
        eighth = fourth * fourth
        for_blue = eighth * eighth
        for_green = for_blue * fourth
        red, green = bright - fall * (value - chunk[RED, i]), bright - fall * (value - chunk[GREEN, i])
        blue = bright - fall * (value - chunk[BLUE, i])
        for_red = second * power
        if share != ONE:
            grey = rest * for_green
            for_red, for_blue = share * for_red + grey, share * for_blue + grey
        chunk[RED, i] = red * (for_red * full)
        chunk[GREEN, i] = green * (for_green * full)
        chunk[BLUE, i] = blue * (for_blue * full)


@part(forceinline=True, fastmath={"contract"})
def _deepened(
    bright: np.float32, value: np.float32, rise: np.float32, terms: tuple[np.float32, ...]
) -> np.float32:
    """Vn, black kept by a smoothstep up to V = 1 / `rise`, and `gamma` where it is not dark."""
    bright = value + faded_to_black(value, rise) * (bright - value)
    bright = bright if bright < ONE else ONE
    deep = value_of(terms, (bright - DIM) * (TWO / (ONE - DIM)) - ONE)
    return bright + faded(bright) * (deep - bright)


@part(forceinline=True, fastmath={"contract"})
def _color_gain(most: np.float32, least: np.float32, pull: np.float32, most_color: np.float32) -> np.float32:
    """Of S between 1 and its bound, over `most`; the hue stays.

    With M and D the largest and the spread of a pixel's channels, S* / S = M D / (D^2 + pull m^2).
    """
    spread = most - least
    spread = spread if spread > TINY * most else TINY * most
    below = spread * spread + pull * least * least
    below = below if below > LEAST_SQUARE * LEAST_SQUARE else LEAST_SQUARE * LEAST_SQUARE
    most = most if most > TINY else TINY
    of_both = ONE / (most * below)  # One division for two.
    inverse, gain = of_both * below, of_both * most * spread
    gain = gain if gain > inverse and pull >= ZERO else inverse
    return gain if gain < most_color * inverse else most_color * inverse
