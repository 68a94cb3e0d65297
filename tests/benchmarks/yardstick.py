"""The yardstick of the speed benchmark: Eqs 1-12 in plain float32 numpy and OpenCV, written with care.

One stage after another over whole images; hue, saturation and value by OpenCV's own conversion. For RGB
uint8 with its own statistics.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.brightness import BLACK, level, z_from_level
from enhance.detail import FLOOR, exponent
from enhance.params import DEFAULTS, EnhanceParams

Plane = NDArray[np.float32]


def enhance_plainly(image: NDArray[np.uint8], params: EnhanceParams = DEFAULTS) -> NDArray[np.uint8]:
    """What `enhance` does, within 1 grey level but for a few bytes."""
    colors = image.astype(np.float32) / np.float32(255)
    hue, chroma, value = cv2.split(cv2.cvtColor(colors, cv2.COLOR_RGB2HSV))
    levels = np.bincount(image.max(axis=2).ravel(), minlength=256)
    z = z_from_level(level(levels)) if params.z is None else params.z
    brightened = (value ** (0.75 * z + 0.25) + 0.4 * (1 - value) * (1 - z) + value ** (2 - z)) / 2
    total = np.zeros_like(value)
    for radius in params.radii:
        filtered = _filtered(value, max(1, (2 * radius + params.subsample) // (2 * params.subsample)), params)
        p = params.p if isinstance(params.p, float) else exponent(255 * float(filtered.std()), params.p_form)
        ratio = (filtered + np.float32(FLOOR)) / (value + np.float32(FLOOR))
        total += brightened ** (np.sqrt(ratio) if p == 0.5 else ratio**p)
    enhanced = total / len(params.radii)
    merged = cv2.merge((hue, _stretched(chroma, params.d_factor), enhanced))
    result = cv2.cvtColor(merged, cv2.COLOR_HSV2RGB)
    if params.keep_black:
        t = np.minimum(value / np.float32(BLACK), 1)
        weight = (t * t * (3 - 2 * t))[..., None]
        result = colors + weight * (result - colors)
    return np.asarray(np.clip(np.rint(result * 255), 0, 255).astype(np.uint8))


def _filtered(value: Plane, radius: int, params: EnhanceParams) -> Plane:
    """Q of Eqs 3-6."""
    rows, columns = value.shape
    low = cv2.resize(
        value, (columns // params.subsample, rows // params.subsample), None, 0, 0, cv2.INTER_AREA
    )
    count = _sum(np.ones_like(low), radius)
    mean = _sum(low, radius) / count
    variance = np.maximum(_sum(low * low, radius) / count - mean * mean, 0)
    a = variance / (variance + np.float32(params.eps))
    b = (1 - a) * mean
    slope, offset = (cv2.resize(_sum(plane, radius) / count, (columns, rows)) for plane in (a, b))
    return np.asarray(slope * value + offset)


def _sum(plane: Plane, radius: int) -> Plane:
    side = (2 * radius + 1, 2 * radius + 1)
    return np.asarray(cv2.boxFilter(plane, -1, side, normalize=False, borderType=cv2.BORDER_CONSTANT))


def _stretched(chroma: Plane, d_factor: float) -> Plane:
    """S* of Eqs 11 and 12."""
    if d_factor == 0:
        return chroma
    mean = float(chroma.mean())
    a, b = (1 - mean) ** 2 * (1 + 2 * mean), mean**2 * (3 - 2 * mean)
    square = a * chroma * chroma
    return np.asarray(square / (square + d_factor * b * (1 - chroma) ** 2 + np.float32(1e-12)))
