"""The passes of the preset `vessel` over an image, between the blurs: each from plane to plane in one go.

Sums are whole numbers and rows stand alone, so results repeat bit for bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from enhance.interleave import deinterleave, interleave
from enhance.powers import exp2, log2, rounded

CHUNK = 128
"""Pixels of a row that are worked on at once; a constant, so that LLVM makes vector code."""
BLOCK = 16
"""Rows of one task."""
BINS = 256
LUMA = (np.float32(0.299), np.float32(0.587), np.float32(0.114))
FLOOR = np.float32(8 / 255)
"""Added before a logarithm, so that noise in the dark is no structure."""
MOST = np.float32(0.5)
"""Bound on the density that is found, a natural logarithm: at strength 1, green falls to 61 % at most."""
DIM, LIT = np.float32(0.15), np.float32(0.4)
"""V between which `gamma` and the layer fade in: dark vessels do not become black."""

ZERO, ONE, TWO, THREE = np.float32(0.0), np.float32(1.0), np.float32(2.0), np.float32(3.0)
LEVELS = np.float32(255.0)
TINY = np.float32(1e-6)
LEAST_SQUARE = np.float32(1e-12)
LN_2, LOG2_E = np.float32(np.log(2)), np.float32(1 / np.log(2))

PLANES, BRIGHT, LEAST, SLOPE, DENSITY = 3, 3, 4, 5, 6
"""Of a chunk, after its three colours."""


@njit(parallel=True, cache=True, error_model="numpy")
def split(
    image: NDArray[Any],  # (H, W, 3)
    full: np.float32,  # the image's value of 1.0
    planes: NDArray[np.float32],  # (3, H, W), out: R, G and B in [0, 1]
) -> None:
    """Colours apart: OpenCV blurs planes faster than pixels."""
    rows, columns = image.shape[0], image.shape[1]
    for block in prange((rows + BLOCK - 1) // BLOCK):
        apart = np.zeros((PLANES, CHUNK), image.dtype)
        for y in range(block * BLOCK, min((block + 1) * BLOCK, rows)):
            for x0 in range(0, columns, CHUNK):
                count = min(CHUNK, columns - x0)
                deinterleave(image[y, x0 : x0 + count], apart)
                for color in range(PLANES):
                    for i in range(count):
                        planes[color, y, x0 + i] = np.float32(apart[color, i]) / full


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def calm(
    planes: NDArray[np.float32],  # (3, H, W)
    smooth: NDArray[np.float32],  # (3, H, W), blurred
    keep: NDArray[np.uint8],  # (H, W) 0 or 1, or empty: all
    out: NDArray[np.float32],  # (H, W, 3), out: smooth, with the fine structure of luma; V never rises
    fade: NDArray[np.float32],  # (H, W), out: smoothstep of its V between DIM and LIT
    histograms: NDArray[np.int64],  # (blocks, BINS), out: of its V in grey levels, over the kept pixels
) -> None:
    """Noise of colour goes, that of brightness stays: differences of R, G and B to luma are smoothed."""
    rows, columns = fade.shape
    for block in prange(len(histograms)):
        chunk = np.zeros((PLANES + 2, CHUNK), np.float32)
        levels = np.empty(CHUNK, np.uint8)
        counts = np.zeros((4, BINS), np.int32)
        for y in range(block * BLOCK, min((block + 1) * BLOCK, rows)):
            for x0 in range(0, columns, CHUNK):
                count = min(CHUNK, columns - x0)
                _settle(planes, smooth, y, x0, count, chunk)
                interleave(chunk, out[y, x0 : x0 + count])
                for i in range(CHUNK):
                    chunk[LEAST, i] = _faded(chunk[BRIGHT, i])
                    levels[i] = np.uint8(np.int32(rounded(chunk[BRIGHT, i] * LEVELS)))  # type: ignore[call-arg]
                for i in range(count):
                    fade[y, x0 + i] = chunk[LEAST, i]
                # Four histograms in turn, as equal neighbours would wait.
                for i in range(count):
                    kept = np.int32(1) if len(keep) == 0 else np.int32(keep[y, x0 + i])
                    counts[i & 3, levels[i]] += kept
        for level in range(BINS):
            histograms[block, level] = counts[:, level].sum()


@njit(inline="always")
def _settle(
    planes: NDArray[np.float32],
    smooth: NDArray[np.float32],
    y: int,
    x0: int,
    count: int,
    chunk: NDArray[np.float32],
) -> None:
    """The calm colours of a chunk, and their V."""
    for i in range(count):
        red, green, blue = planes[0, y, x0 + i], planes[1, y, x0 + i], planes[2, y, x0 + i]
        soft_red, soft_green, soft_blue = smooth[0, y, x0 + i], smooth[1, y, x0 + i], smooth[2, y, x0 + i]
        fine = LUMA[0] * (red - soft_red) + LUMA[1] * (green - soft_green) + LUMA[2] * (blue - soft_blue)
        most = max(max(red, green), blue)
        chunk[0, i] = min(max(soft_red + fine, ZERO), most)
        chunk[1, i] = min(max(soft_green + fine, ZERO), most)
        chunk[2, i] = min(max(soft_blue + fine, ZERO), most)
        chunk[BRIGHT, i] = max(max(chunk[0, i], chunk[1, i]), chunk[2, i])


@njit(inline="always")
def _faded(value: np.float32) -> np.float32:
    """Smoothstep of V between DIM and LIT."""
    t = (value - DIM) * (ONE / (LIT - DIM))
    t = min(max(t, ZERO), ONE)
    return t * t * (THREE - TWO * t)


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def absorb(
    red: NDArray[np.float32],  # (H, W), blurred
    green: NDArray[np.float32],  # (H, W), blurred
    shading: np.float32,
    out: NDArray[np.float32],  # (H, W), out: natural logarithm
) -> None:
    """What green lacks beside red: `shading` log red - log green."""
    rows, columns = out.shape
    for y in prange(rows):
        for x in range(columns):
            lack = shading * log2(red[y, x] + FLOOR) - log2(green[y, x] + FLOOR)
            out[y, x] = LN_2 * lack


@njit(parallel=True, cache=True, fastmath={"contract"}, error_model="numpy")
def finish(
    toned: NDArray[np.float32],  # (H, W, 3) after the paper's brightness and detail
    fade: NDArray[np.float32],  # (H, W) of `calm`
    absorbed: NDArray[np.float32],  # (H, W) of `absorb`
    opened: NDArray[np.float32],  # (H, W), its morphological opening
    gamma: np.float32,  # exponent of V
    pull: np.float32,  # k B / A of Eq 11; negative: S stays
    most_color: np.float32,  # bound on the gain of S
    strength: np.float32,
    noise: np.float32,  # density below which structures are hardly strengthened
    shares: NDArray[np.float32],  # (3,) of the density that R, G and B lose
    full: np.float32,  # 1.0 in the result
    image: NDArray[Any],  # (H, W, 3), of the type of `out`
    spans: NDArray[np.int32],  # (H, 2) of `FieldOfView.spans`, or empty: all; outside, `image` stays
    out: NDArray[Any],  # (H, W, 3), out, in [0, full]
) -> None:
    """`gamma` on V, Eqs 11 and 12 on S within bounds, then attenuation by the density of blood."""
    rows, columns = fade.shape
    for block in prange((rows + BLOCK - 1) // BLOCK):
        chunk = np.zeros((DENSITY + 1, CHUNK), np.float32)
        line = np.zeros((3, CHUNK), np.float32)
        apart = np.zeros((PLANES, CHUNK), out.dtype)
        for y in range(block * BLOCK, min((block + 1) * BLOCK, rows)):
            first, end = (spans[y, 0], spans[y, 1]) if len(spans) > 0 else (0, columns)
            for x0 in range(first // CHUNK * CHUNK, end if end > first else 0, CHUNK):
                count = min(CHUNK, columns - x0)
                deinterleave(toned[y, x0 : x0 + count], chunk)
                for i in range(count):
                    line[0, i] = fade[y, x0 + i]
                    line[1, i] = absorbed[y, x0 + i]
                    line[2, i] = opened[y, x0 + i]
                _color(chunk, gamma, pull, most_color)
                _find(chunk, line, strength, noise)
                for color in range(PLANES):
                    share = shares[color] * LOG2_E
                    for i in range(CHUNK):
                        tinted = chunk[color, i] * exp2(-share * chunk[DENSITY, i]) * full
                        tinted = min(max(tinted, ZERO), full)
                        apart[color, i] = rounded(tinted) if full > ONE else tinted  # type: ignore[call-arg]
                interleave(apart, out[y, x0 : x0 + count])
            out[y, :first] = image[y, :first]
            out[y, end:] = image[y, end:]


@njit(inline="always")
def _color(chunk: NDArray[np.float32], gamma: np.float32, pull: np.float32, most_color: np.float32) -> None:
    """`gamma` on V where that is not dark, the gain of S between 1 and its bound; the hue stays."""
    for i in range(CHUNK):
        red, green, blue = chunk[0, i], chunk[1, i], chunk[2, i]
        bright = max(max(red, green), blue)
        least = min(min(red, green), blue)
        deep = bright + _faded(bright) * (exp2(gamma * log2(bright)) - bright)
        safe = max(bright, TINY)
        white = least / safe
        chroma = max(ONE - white, TINY)
        gain = chroma / (chroma * chroma + pull * white * white) if pull >= ZERO else ONE
        gain = min(max(gain, ONE), min(most_color, ONE / chroma))
        chunk[BRIGHT, i], chunk[LEAST, i], chunk[SLOPE, i] = bright, deep, deep / safe * gain
    for color in range(PLANES):
        for i in range(CHUNK):
            chunk[color, i] = chunk[LEAST, i] - chunk[SLOPE, i] * (chunk[BRIGHT, i] - chunk[color, i])


@njit(inline="always")
def _find(
    chunk: NDArray[np.float32], line: NDArray[np.float32], strength: np.float32, noise: np.float32
) -> None:
    """The density of blood times `strength`: top-hat, coring, and a soft bound by the hyperbolic tangent."""
    for i in range(CHUNK):
        found = max(line[1, i] - line[2, i], ZERO)
        square = found * found
        cored = found * square / (square + noise * noise + LEAST_SQUARE)
        grown = exp2(min(TWO * LOG2_E / MOST * cored, np.float32(80)))
        chunk[DENSITY, i] = strength * line[0, i] * MOST * (ONE - TWO / (grown + ONE))
