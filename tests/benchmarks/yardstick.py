"""The yardstick of the speed benchmark: Eqs 1-12 in plain float32 numpy and OpenCV, written with care.

One stage after another over whole images, what there is a call for by that call: conversions, powers, means,
resizing; exponents of 1/2 as square roots; nothing reckoned twice, and nothing but the equations, so without
`keep_black`. For RGB uint8 with its own statistics.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.brightness import level, z_from_level
from enhance.detail import FLOOR, exponent
from enhance.params import DEFAULTS, EnhanceParams

Plane = NDArray[np.float32]


def enhance_plainly(image: NDArray[np.uint8], params: EnhanceParams = DEFAULTS) -> NDArray[np.uint8]:
    """What `enhance` does without `keep_black`, within a grey level but near the borders."""
    colors = cv2.cvtColor(cv2.multiply(image, 1.0, None, 1 / 255, cv2.CV_32F), cv2.COLOR_RGB2HSV)
    hue, chroma, value = cv2.split(colors)
    z = _z(value) if params.z is None else params.z
    enhanced = _detailed(value, _brightened(value, z), params)
    merged = cv2.merge((hue, _stretched(chroma, params.k), enhanced))
    return np.asarray(cv2.convertScaleAbs(cv2.cvtColor(merged, cv2.COLOR_HSV2RGB), None, 255))


def _z(value: Plane) -> float:
    """Eq 2."""
    levels = cv2.calcHist([cv2.convertScaleAbs(value, None, 255)], [0], None, [256], [0, 256])
    return z_from_level(level(levels.ravel().astype(np.int64).cumsum()))


def _brightened(value: Plane, z: float) -> Plane:
    """Eq 1."""
    total = cv2.addWeighted(cv2.pow(value, 0.75 * z + 0.25), 0.5, cv2.pow(value, 2 - z), 0.5, 0.2 * (1 - z))
    return np.asarray(cv2.scaleAdd(value, -0.2 * (1 - z), total))


def _detailed(value: Plane, brightened: Plane, params: EnhanceParams) -> Plane:
    """Eqs 3-10; a power is the exponential of a logarithm that all scales share."""
    rows, columns = value.shape
    size = columns // params.subsample, rows // params.subsample
    low = cv2.resize(value, size, None, 0, 0, cv2.INTER_AREA)
    square, logarithm = low * low, cv2.log(np.maximum(brightened, np.float32(1e-30)))
    inverse = 1 / (value + np.float32(FLOOR))
    total = np.zeros_like(value)
    for radius in params.radii:
        side = 2 * max(1, (2 * radius + params.subsample) // (2 * params.subsample)) + 1
        mean = cv2.blur(low, (side, side))
        variance = np.maximum(cv2.blur(square, (side, side)) - mean * mean, 0)
        a = variance / (variance + np.float32(params.eps))
        b = (1 - a) * mean
        slope, offset = (cv2.resize(cv2.blur(plane, (side, side)), (columns, rows)) for plane in (a, b))
        filtered = slope * value + offset
        p = params.p if isinstance(params.p, float) else exponent(_deviation(filtered), params.p_form)
        ratio = (filtered + np.float32(FLOOR)) * inverse
        power = cv2.sqrt(ratio) if p == 0.5 else cv2.pow(ratio, p)
        total += cv2.exp(power * logarithm)
    return np.asarray(total * np.float32(1 / len(params.radii)))


def _deviation(filtered: Plane) -> float:
    """In grey levels."""
    return 255 * float(cv2.meanStdDev(filtered)[1][0, 0])


def _stretched(chroma: Plane, d_factor: float) -> Plane:
    """S* of Eqs 11 and 12."""
    if d_factor == 0:
        return chroma
    mean = cv2.mean(chroma)[0]
    a, b = (1 - mean) ** 2 * (1 + 2 * mean), mean**2 * (3 - 2 * mean)
    square = chroma * chroma * np.float32(a)
    rest = 1 - chroma
    return np.asarray(square / (square + rest * rest * np.float32(d_factor * b) + np.float32(1e-12)))
