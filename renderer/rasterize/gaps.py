"""Closes small gaps in a view, tile by tile, by sums that run down columns and along rows; see closing.py."""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit, prange

from renderer.splats import Float32Array

TILE: Final = 128
"""Pixels a side of what is looked at at once: much of an image from beside is empty. Sums begin anew in each,
so that rounding does not add up."""
_NONE, _ONE, _TWO, _THREE = (np.float32(value) for value in range(4))


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def close(
    image: Float32Array,  # (H, 3 W)
    alpha: Float32Array,  # (H, W)
    radius: int,
    gone: np.float32,
    whole: np.float32,
    closed_image: Float32Array,  # as they are, out
    closed_alpha: Float32Array,
) -> None:
    height, width = alpha.shape
    columns = (width + TILE - 1) // TILE
    for tile in prange((height + TILE - 1) // TILE * columns):
        top, left = tile // columns * TILE, tile % columns * TILE
        right, count = min(left + TILE, width), min(TILE, width - left)
        first, last = max(left - radius, 0), min(right + radius, width)
        begin, end = max(top - radius, 0), min(top + TILE + radius, height)
        if _is_empty(alpha, begin, end, first, last):
            for y in range(top, min(top + TILE, height)):
                _clear(closed_image[y, 3 * left : 3 * right])
                _clear(closed_alpha[y, left:right])
            continue
        # Sums over the rows of a window, 0 in columns beside the image; and all of a window.
        alphas = np.zeros(count + 2 * radius, np.float32)
        colors = np.zeros(3 * len(alphas), np.float32)
        share, around = np.empty(count, np.float32), np.empty(3 * count, np.float32)
        widths = np.empty(count, np.float32)
        for x in range(left, right):
            widths[x - left] = min(x + radius, width - 1) - max(x - radius, 0) + 1
        ahead = radius - (left - first)
        summed = alphas[ahead : ahead + last - first]
        summed_colors = colors[3 * ahead : 3 * (ahead + last - first)]
        reached = slice(3 * first, 3 * last)
        for y in range(begin, min(top + radius, end)):
            _add(alpha[y, first:last], _ONE, summed)
            _add(image[y, reached], _ONE, summed_colors)
        for y in range(top, min(top + TILE, height)):
            if y + radius < end:
                _add(alpha[y + radius, first:last], _ONE, summed)
                _add(image[y + radius, reached], _ONE, summed_colors)
            if y > top and y - radius - 1 >= begin:
                _add(alpha[y - radius - 1, first:last], -_ONE, summed)
                _add(image[y - radius - 1, reached], -_ONE, summed_colors)
            _run(alphas, colors, radius, share, around)
            tall = min(y + radius, height - 1) - max(y - radius, 0) + 1
            kept = closed_alpha[y, left:right]
            _set_weights(share, alpha[y, left:right], widths, np.float32(tall), gone, whole, kept)
            pixels = slice(3 * left, 3 * right)
            _lay(image[y, pixels], around, kept, share, closed_image[y, pixels])


@njit(error_model="numpy")
def _is_empty(alpha: Float32Array, begin: int, end: int, first: int, last: int) -> bool:
    # Row by row: of a part of several rows the compiler does not know that pixels lie side by side.
    y = begin
    while y < end and _sum(alpha[y, first:last]) == _NONE:
        y += 1
    return y == end


@njit(fastmath={"contract", "reassoc"}, error_model="numpy")
def _sum(values: Float32Array) -> np.float32:
    total = _NONE
    for i in range(len(values)):
        total += values[i]
    return total


@njit(error_model="numpy")
def _clear(values: Float32Array) -> None:
    for i in range(len(values)):
        values[i] = _NONE


@njit(fastmath={"contract"}, error_model="numpy")
def _add(values: Float32Array, sign: np.float32, sums: Float32Array) -> None:
    for i in range(len(sums)):
        sums[i] += sign * values[i]


@njit(fastmath={"contract"}, error_model="numpy")
def _run(
    alphas: Float32Array,  # (K + 2 radius,)
    colors: Float32Array,  # (3 (K + 2 radius),)
    radius: int,
    share: Float32Array,  # (K,) sums of 2 radius + 1 of them, out
    around: Float32Array,  # (3 K,) out
) -> None:
    alpha = red = green = blue = _NONE
    for x in range(2 * radius):
        alpha += alphas[x]
        red += colors[3 * x]
        green += colors[3 * x + 1]
        blue += colors[3 * x + 2]
    for x in range(len(share)):
        ahead = x + 2 * radius
        alpha += alphas[ahead]
        red += colors[3 * ahead]
        green += colors[3 * ahead + 1]
        blue += colors[3 * ahead + 2]
        share[x], around[3 * x], around[3 * x + 1], around[3 * x + 2] = alpha, red, green, blue
        alpha -= alphas[x]
        red -= colors[3 * x]
        green -= colors[3 * x + 1]
        blue -= colors[3 * x + 2]


@njit(fastmath={"contract"}, error_model="numpy")
def _set_weights(
    share: Float32Array,  # (K,) alpha summed over windows; of their summed colours the share to add, out
    alpha: Float32Array,  # (K,)
    widths: Float32Array,  # (K,) columns of the windows
    height: np.float32,  # their rows
    gone: np.float32,
    whole: np.float32,
    closed_alpha: Float32Array,  # (K,), out
) -> None:
    for x in range(len(share)):
        t = (share[x] / (height * widths[x]) - gone) / (whole - gone)
        t = min(max(t, _NONE), _ONE)
        t = t * t * (_THREE - _TWO * t)
        closed_alpha[x] = t
        share[x] = t * (_ONE - alpha[x]) / share[x] if t > _NONE else _NONE


@njit(fastmath={"contract"}, error_model="numpy")
def _lay(
    image: Float32Array,  # (3 K,)
    around: Float32Array,  # (3 K,)
    kept: Float32Array,  # (K,)
    filled: Float32Array,  # (K,)
    closed_image: Float32Array,  # (3 K,), out
) -> None:
    for x in range(len(kept)):
        share, fill = kept[x], filled[x]
        closed_image[3 * x] = share * image[3 * x] + fill * around[3 * x]
        closed_image[3 * x + 1] = share * image[3 * x + 1] + fill * around[3 * x + 1]
        closed_image[3 * x + 2] = share * image[3 * x + 2] + fill * around[3 * x + 2]
