"""Real spherical harmonics of degree 1 to 3: the part of a colour that depends on where it is seen from.

A splat's colour is colors + sum_b Y_b(d) h_b, d being the unit vector from the camera's centre to its mean,
in world axes. Order and signs of the B = 3, 8 or 15 functions are those of 3D Gaussian Splatting (Kerbl et
al. 2023) and its files: l = 1, 2, 3 with m = -l to l in each, and the Condon-Shortley phase. The constant
function is in `colors`, which is 0.5 + 0.2820948 times the files' coefficient of degree 0.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

Float32Array = NDArray[np.float32]
BANDS = (0, 3, 8, 15)
"""Number of functions of degree 1 up to degree 0, 1, 2, 3."""

F = np.float32
_P1 = F(math.sqrt(3 / (4 * math.pi)))
_D2, _D0, _D22 = (F(math.sqrt(x / math.pi)) for x in (15 / 4, 5 / 16, 15 / 16))
_F3, _F2, _F1, _F0, _F22 = (F(math.sqrt(x / math.pi)) for x in (35 / 32, 105 / 4, 21 / 32, 7 / 16, 105 / 16))


def seen_colors(
    means: Float32Array, harmonics: Float32Array, colors: Float32Array, center: NDArray[np.float64]
) -> Float32Array:
    """Colours (N, 3) of means (N, 3) with harmonics (N, B, 3) and colors (N, 3) from `center` (3,).

    Not clamped: a sum below 0 is blended as it stands, and only the finished picture is clipped.
    """
    seen = colors.copy()
    add_harmonics(means, harmonics, center, seen)
    return seen


@njit(forceinline=True, error_model="numpy")
def _direction(mean: Float32Array, center: NDArray[np.float64]) -> tuple[Any, Any, Any, Any]:
    """Unit vector from the centre to the mean and 1 / distance; all 0 where the two coincide."""
    x, y, z = mean[0] - center[0], mean[1] - center[1], mean[2] - center[2]
    length = math.sqrt(x * x + y * y + z * z)
    nearness = 1.0 / length if length > 0.0 else 0.0
    return F(x * nearness), F(y * nearness), F(z * nearness), F(nearness)


@njit(forceinline=True, error_model="numpy")
def _evaluate(x: Any, y: Any, z: Any, count: int, out: Float32Array) -> None:
    """The functions at a unit vector (x, y, z)."""
    xx, yy, zz = x * x, y * y, z * z
    out[0], out[1], out[2] = -_P1 * y, _P1 * z, -_P1 * x
    if count > 3:
        out[3], out[4] = _D2 * x * y, -_D2 * y * z
        out[5] = _D0 * (F(2) * zz - xx - yy)
        out[6], out[7] = -_D2 * x * z, _D22 * (xx - yy)
    if count > 8:
        out[8], out[14] = -_F3 * y * (F(3) * xx - yy), -_F3 * x * (xx - F(3) * yy)
        out[9], out[13] = _F2 * x * y * z, _F22 * z * (xx - yy)
        out[10], out[12] = -_F1 * y * (F(4) * zz - xx - yy), -_F1 * x * (F(4) * zz - xx - yy)
        out[11] = _F0 * z * (F(2) * zz - F(3) * (xx + yy))


@njit(forceinline=True, error_model="numpy")
def _slope(x: Any, y: Any, z: Any, g: Float32Array) -> tuple[Any, Any, Any]:
    """Gradient by (x, y, z) of sum_b g_b Y_b, the functions read as the polynomials of `_evaluate`."""
    xx, yy, zz = x * x, y * y, z * z
    by_x, by_y, by_z = -_P1 * g[2], -_P1 * g[0], _P1 * g[1]
    if len(g) > 3:
        by_x += _D2 * (g[3] * y - g[6] * z) + F(2) * x * (_D22 * g[7] - _D0 * g[5])
        by_y += _D2 * (g[3] * x - g[4] * z) - F(2) * y * (_D22 * g[7] + _D0 * g[5])
        by_z += F(4) * _D0 * g[5] * z - _D2 * (g[4] * y + g[6] * x)
    if len(g) > 8:
        by_x += F(3) * _F3 * (g[14] * (yy - xx) - F(2) * g[8] * x * y) + _F2 * g[9] * y * z
        by_x += _F1 * (F(2) * g[10] * x * y - g[12] * (F(4) * zz - F(3) * xx - yy))
        by_x += F(2) * x * z * (_F22 * g[13] - F(3) * _F0 * g[11])
        by_y += F(3) * _F3 * (g[8] * (yy - xx) + F(2) * g[14] * x * y) + _F2 * g[9] * x * z
        by_y += _F1 * (F(2) * g[12] * x * y - g[10] * (F(4) * zz - xx - F(3) * yy))
        by_y -= F(2) * y * z * (_F22 * g[13] + F(3) * _F0 * g[11])
        by_z += _F2 * g[9] * x * y + _F22 * g[13] * (xx - yy) - F(8) * _F1 * z * (g[10] * y + g[12] * x)
        by_z += F(3) * _F0 * g[11] * (F(2) * zz - xx - yy)
    return by_x, by_y, by_z


@njit(parallel=True, cache=True, error_model="numpy")
def add_harmonics(
    means: Float32Array,  # (N, 3)
    harmonics: Float32Array,  # (N, B, 3)
    center: NDArray[np.float64],  # (3,)
    colors: Float32Array,  # (N, 3), added to
) -> None:
    """Add what each splat shows in the direction from `center`."""
    count = harmonics.shape[1]
    for n in prange(means.shape[0]):
        values = np.empty(15, np.float32)
        x, y, z, _ = _direction(means[n], center)
        _evaluate(x, y, z, count, values)
        for c in range(3):
            total = F(0)
            for b in range(count):
                total += values[b] * harmonics[n, b, c]
            colors[n, c] += total


@njit(parallel=True, cache=True, error_model="numpy")
def harmonics_backward(
    means: Float32Array,  # (N, 3)
    harmonics: Float32Array,  # (N, B, 3)
    center: NDArray[np.float64],  # (3,)
    seen: NDArray[np.bool_],  # (N,)
    by_colors: Float32Array,  # (N, 3)
    by_harmonics: Float32Array,  # (N, B, 3), out: 0 where a splat is not seen
    by_means: Float32Array,  # (N, 3), added to
) -> None:
    """Backward of `add_harmonics`: by the coefficients, and by the means through the direction."""
    count = harmonics.shape[1]
    for n in prange(means.shape[0]):
        if not seen[n]:
            by_harmonics[n] = F(0)
            continue
        values, by_values = np.empty(15, np.float32), np.empty(count, np.float32)
        x, y, z, nearness = _direction(means[n], center)
        _evaluate(x, y, z, count, values)
        for b in range(count):
            by_value = F(0)
            for c in range(3):
                by_harmonics[n, b, c] = values[b] * by_colors[n, c]
                by_value += harmonics[n, b, c] * by_colors[n, c]
            by_values[b] = by_value
        by_x, by_y, by_z = _slope(x, y, z, by_values)
        # A change along the direction does not turn it.
        along = by_x * x + by_y * y + by_z * z
        by_means[n, 0] += nearness * (by_x - along * x)
        by_means[n, 1] += nearness * (by_y - along * y)
        by_means[n, 2] += nearness * (by_z - along * z)
