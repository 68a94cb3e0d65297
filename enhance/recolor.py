"""Colours of a chunk: from V* to the pixels that are written."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from enhance.interleave import interleave
from enhance.part import part
from enhance.pixel_block import (
    BINS,
    BLUE,
    CHUNK,
    GREEN,
    LEAST,
    LEAST_COLOR,
    LEVELS,
    MOST,
    OFFSET,
    ONE,
    RED,
    SLOPE,
    THREE,
    TOTAL,
    TWO,
    VALUE,
    ZERO,
)
from enhance.powers import rounded
from enhance.wide_vectors import wide_vectors

BLACK = np.float32(24 / 255)


@part(forceinline=True, fastmath={"contract"})
def recolor(
    chunk: NDArray[np.float32], apart: NDArray[Any], pull: np.float32, color: np.float32, full: np.float32
) -> None:
    """Colours of V* and S* (Eqs 11, 12) with the old hue: c becomes V* (1 - S* (M - c) / D), one division."""
    wide_vectors()
    if pull >= ZERO:
        for i in range(CHUNK):
            most, least = chunk[MOST, i], chunk[LEAST_COLOR, i]
            spread = most - least
            below = spread * spread + pull * least * least
            chunk[SLOPE, i] = spread / (below if below > LEAST else LEAST)
    else:
        for i in range(CHUNK):
            most = chunk[MOST, i]
            chunk[SLOPE, i] = ONE / (most if most > LEAST else LEAST)
    if color < ONE:
        for i in range(CHUNK):
            most = chunk[MOST, i]
            chunk[SLOPE, i] = color * chunk[SLOPE, i] + (ONE - color) / (most if most > LEAST else LEAST)
    for i in range(CHUNK):
        value, most = chunk[TOTAL, i] * full, chunk[MOST, i]
        fall = value * chunk[SLOPE, i]
        chunk[RED, i] = value - fall * (most - np.float32(apart[RED, i]))
        chunk[GREEN, i] = value - fall * (most - np.float32(apart[GREEN, i]))
        chunk[BLUE, i] = value - fall * (most - np.float32(apart[BLUE, i]))


@part(forceinline=True, fastmath={"contract"})
def is_dark(chunk: NDArray[np.float32]) -> bool:
    """Whether any pixel is below V = 24/255; whole numbers, as minima of floats are not reordered."""
    darkest = np.int32(BINS)
    for i in range(CHUNK):
        darkest = min(darkest, np.int32(chunk[VALUE, i] * LEVELS))
    return bool(darkest < 24)


@part(forceinline=True, fastmath={"contract"})
def faded_to_black(value: np.float32, rise: np.float32) -> np.float32:
    """`keep_black`: a smoothstep of V that is 0 at V = 0 and 1 from V = 1 / `rise` on."""
    t = value * rise
    t = t if t < ONE else ONE
    return t * t * (THREE - TWO * t)


@part(fastmath={"contract"})
def fade(chunk: NDArray[np.float32], apart: NDArray[Any]) -> None:
    """`keep_black`: back to the original colours below V = 24/255, by a smoothstep that is 0 at V = 0."""
    wide_vectors()
    for i in range(CHUNK):
        chunk[OFFSET, i] = faded_to_black(chunk[VALUE, i], ONE / BLACK)
    for plane in range(3):
        for i in range(CHUNK):
            weight = chunk[OFFSET, i]
            chunk[plane, i] = weight * chunk[plane, i] + (ONE - weight) * np.float32(apart[plane, i])


@part(forceinline=True, fastmath={"contract"})
def store(chunk: NDArray[np.float32], full: np.float32, apart: NDArray[Any], pixels: NDArray[Any]) -> None:
    wide_vectors()
    if full > ONE:
        for plane in range(3):
            for i in range(CHUNK):
                level = np.int32(rounded(chunk[plane, i]))  # type: ignore[call-arg]
                apart[plane, i] = min(max(level, np.int32(0)), np.int32(full))
    else:
        for plane in range(3):
            for i in range(CHUNK):
                color = chunk[plane, i]
                color = color if color < full else full
                apart[plane, i] = color if color > ZERO else ZERO
    interleave(apart, pixels)
