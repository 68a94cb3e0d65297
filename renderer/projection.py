"""Projection of 3-D Gaussians to 2-D splats (paper Eqs 13-15) and its gradient, one thread a share.

The arithmetic is float64: it costs little beside the raster and stands scales from 1e-8 to 1e8.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.camera import Camera, FloatArray
from renderer.stack_arrays import stack_array64

LOW_PASS = 0.3
"""Variance in square pixels added on both axes of the screen covariance."""
ALPHA_CUT = 1.0 / 255.0
"""Contributions below this are dropped."""
NEAR = 0.01
"""Default near plane in scene units."""

# Columns of a splat record (float32). The exponent of 2 of alpha at offset (dx, dy) from the centre is
# LOG2_OPACITY + ACROSS (dx + SHEAR dy)^2 + DOWN dy^2: of two squares, since the three terms of the plain form
# would cancel where a long splat is seen far from its centre. ACROSS is of x for a known y, DOWN of y alone.
CENTER_X, CENTER_Y, ACROSS, SHEAR, DOWN, LOG2_OPACITY = range(6)
RED, GREEN, BLUE, DEPTH, HALF_WIDTH, HALF_HEIGHT = range(6, 12)
RECORD_SIZE = 12

# Columns of the gradient sums that the raster's backward pass leaves for each splat: q is the
# derivative by the natural logarithm of alpha, summed with the moments of the pixel offset.
SUM_Q, SUM_QX, SUM_QY, SUM_QXX, SUM_QXY, SUM_QYY, SUM_RED, SUM_GREEN, SUM_BLUE, SUM_DEPTH = range(10)
SUM_SIZE = 10

LOG2_E = 1.0 / math.log(2.0)
LN_2 = np.float32(math.log(2.0))


def camera_vector(camera: Camera, near: float) -> FloatArray:
    """Camera as one float64 row for the kernels: intrinsics, limits of x/z and y/z for J, near, pose.

    J is built with x/z and y/z clamped to the image edges widened by 0.3 tan(fov / 2), so that a
    splat far beside the view does not smear across it.
    """
    margin_x, margin_y = 0.15 * camera.width / camera.fx, 0.15 * camera.height / camera.fy
    head = [
        camera.fx, camera.fy, camera.cx, camera.cy,
        -camera.cx / camera.fx - margin_x, (camera.width - camera.cx) / camera.fx + margin_x,
        -camera.cy / camera.fy - margin_y, (camera.height - camera.cy) / camera.fy + margin_y,
        near,
    ]  # fmt: skip
    return np.array([*head, *camera.camera_from_world[:3].ravel()])


@njit(forceinline=True, error_model="numpy")
def _rotation(quat: NDArray[np.float32], out: FloatArray) -> None:
    """Rotation matrix of a wxyz quaternion of any length; the zero quaternion is the identity."""
    w, x, y, z = np.float64(quat[0]), np.float64(quat[1]), np.float64(quat[2]), np.float64(quat[3])
    length = math.sqrt(w * w + x * x + y * y + z * z)
    if length == 0.0:
        w = length = np.float64(1.0)
    w, x, y, z = w / length, x / length, y / length, z / length
    out[0, 0], out[0, 1], out[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    out[1, 0], out[1, 1], out[1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    out[2, 0], out[2, 1], out[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


@njit(forceinline=True, error_model="numpy")
def _to_camera(mean: NDArray[np.float32], view: FloatArray, out: FloatArray) -> None:
    for i in range(3):
        row = 9 + 4 * i
        out[i] = view[row] * mean[0] + view[row + 1] * mean[1] + view[row + 2] * mean[2] + view[row + 3]


@njit(forceinline=True, error_model="numpy")
def _screen_axes(
    local: FloatArray, view: FloatArray, rotation: FloatArray, scale: NDArray[np.float32], out: FloatArray
) -> None:
    """(2, 3) matrix J W R S: screen covariance = out out^T (Eqs 14, 15)."""
    z = local[2]
    across = min(max(local[0] / z, view[4]), view[5])
    down = min(max(local[1] / z, view[6]), view[7])
    for j in range(3):
        x = y = depth = 0.0
        for k in range(3):
            x += view[9 + k] * rotation[k, j]
            y += view[13 + k] * rotation[k, j]
            depth += view[17 + k] * rotation[k, j]
        out[0, j] = view[0] / z * (x - across * depth) * scale[j]
        out[1, j] = view[1] / z * (y - down * depth) * scale[j]


@njit(forceinline=True, error_model="numpy")
def _minors(axes: FloatArray) -> tuple[float, float, float]:
    """The three of axes: the squares add up to the determinant of axes axes^T (Cauchy-Binet), which would
    cancel as xx yy - xy^2."""
    return (
        axes[0, 0] * axes[1, 1] - axes[0, 1] * axes[1, 0],
        axes[0, 0] * axes[1, 2] - axes[0, 2] * axes[1, 0],
        axes[0, 1] * axes[1, 2] - axes[0, 2] * axes[1, 1],
    )


@njit(forceinline=True, error_model="numpy")
def _sharp_determinant(axes: FloatArray) -> float:
    """Determinant of axes axes^T."""
    first, second, third = _minors(axes)
    determinant: float = first**2 + second**2 + third**2
    return determinant


@njit(forceinline=True, error_model="numpy")
def _covariance(axes: FloatArray) -> tuple[float, float, float, float]:
    """xx, xy, yy of axes axes^T + LOW_PASS I, and its determinant, a sum of squares."""
    xx = axes[0, 0] ** 2 + axes[0, 1] ** 2 + axes[0, 2] ** 2 + LOW_PASS
    xy = axes[0, 0] * axes[1, 0] + axes[0, 1] * axes[1, 1] + axes[0, 2] * axes[1, 2]
    yy = axes[1, 0] ** 2 + axes[1, 1] ** 2 + axes[1, 2] ** 2 + LOW_PASS
    return xx, xy, yy, _sharp_determinant(axes) + LOW_PASS * (xx + yy - LOW_PASS)


@njit(parallel=True, cache=True, error_model="numpy")
def project(
    means: NDArray[np.float32],  # (N, 3)
    quats: NDArray[np.float32],  # (N, 4)
    scales: NDArray[np.float32],  # (N, 3)
    opacities: NDArray[np.float32],  # (N,)
    colors: NDArray[np.float32],  # (N, 3)
    view: FloatArray,
    compensated: bool,
    records: NDArray[np.float32],  # (N, RECORD_SIZE), out
    visible: NDArray[np.bool_],  # (N,), out
) -> None:
    """Fill the splat records; `visible` is False behind the near plane, below the cut or not finite.

    `compensated`: a splat keeps the share sqrt(det C / det(C + LOW_PASS I)) of its opacity, both determinants
    sums of squares, which makes up for the low-pass filter. Source: Mip-Splatting (Yu et al. 2024).
    """
    for n in prange(means.shape[0]):
        rotation, local, axes = stack_array64(3, 3), stack_array64(3), stack_array64(2, 3)
        visible[n] = False
        _to_camera(means[n], view, local)
        opacity = np.float64(opacities[n])
        if not (local[2] > view[8] and opacity >= ALPHA_CUT):
            continue
        _rotation(quats[n], rotation)
        _screen_axes(local, view, rotation, scales[n], axes)
        xx, xy, yy, determinant = _covariance(axes)
        if not (determinant > 0.0 and determinant < np.inf):
            continue
        if compensated:
            opacity *= math.sqrt(min(_sharp_determinant(axes) / determinant, 1.0))
            if not opacity >= ALPHA_CUT:
                continue
        reach = 2.0 * math.log(opacity / ALPHA_CUT)
        record = records[n]
        record[CENTER_X] = view[0] * local[0] / local[2] + view[2]
        record[CENTER_Y] = view[1] * local[1] / local[2] + view[3]
        record[ACROSS] = -0.5 * LOG2_E * yy / determinant
        record[SHEAR] = -xy / yy
        record[DOWN] = -0.5 * LOG2_E / yy
        record[LOG2_OPACITY] = math.log(opacity) * LOG2_E
        record[RED], record[GREEN], record[BLUE] = colors[n, 0], colors[n, 1], colors[n, 2]
        record[DEPTH] = local[2]
        record[HALF_WIDTH] = math.sqrt(reach * xx) + 1e-3
        record[HALF_HEIGHT] = math.sqrt(reach * yy) + 1e-3
        colored = math.isfinite(record[RED]) and math.isfinite(record[GREEN]) and math.isfinite(record[BLUE])
        visible[n] = colored and record[HALF_WIDTH] < np.inf and record[HALF_HEIGHT] < np.inf


@njit(forceinline=True, error_model="numpy")
def _conic_gradient(
    sums: NDArray[np.float32], xx: float, xy: float, yy: float, determinant: float, out: FloatArray
) -> None:
    """Gradient (gxx, gxy, gyy) by the screen covariance, from that by its inverse: -M G M."""
    a, b, c = yy / determinant, -xy / determinant, xx / determinant
    ga, gb, gc = -0.5 * sums[SUM_QXX], -0.5 * sums[SUM_QXY], -0.5 * sums[SUM_QYY]
    left_a, left_b = a * ga + b * gb, a * gb + b * gc
    right_a, right_b = b * ga + c * gb, b * gb + c * gc
    out[0] = -(left_a * a + left_b * b)
    out[1] = -(left_a * b + left_b * c)
    out[2] = -(right_a * b + right_b * c)


@njit(forceinline=True, error_model="numpy")
def _add_compensation_gradient(
    axes: FloatArray, xx: float, xy: float, yy: float, determinant: float, by_log: float, out: FloatArray
) -> None:
    """Added to the gradient by the axes (2, 3): what the share of the opacity that a splat keeps adds, from
    the gradient by its logarithm. The share is above the cut, or there would be no gradient."""
    first, second, third = _minors(axes)
    sharp = first * first + second * second + third * third
    upper = (
        first * axes[1, 1] + second * axes[1, 2],
        third * axes[1, 2] - first * axes[1, 0],
        -second * axes[1, 0] - third * axes[1, 1],
    )
    lower = (
        -first * axes[0, 1] - second * axes[0, 2],
        first * axes[0, 0] - third * axes[0, 2],
        second * axes[0, 0] + third * axes[0, 1],
    )
    for j in range(3):
        out[0, j] += by_log * (upper[j] / sharp - (yy * axes[0, j] - xy * axes[1, j]) / determinant)
        out[1, j] += by_log * (lower[j] / sharp - (xx * axes[1, j] - xy * axes[0, j]) / determinant)


@njit(forceinline=True, error_model="numpy")
def _quaternion_gradient(
    quat: NDArray[np.float32], by_rotation: FloatArray, out: NDArray[np.float32]
) -> None:
    """Gradient by the raw quaternion; its part along the quaternion vanishes, as length has no effect."""
    w, x, y, z = np.float64(quat[0]), np.float64(quat[1]), np.float64(quat[2]), np.float64(quat[3])
    length = math.sqrt(w * w + x * x + y * y + z * z)
    if length == 0.0:
        out[0] = out[1] = out[2] = out[3] = 0.0
        return
    w, x, y, z = w / length, x / length, y / length, z / length
    g = by_rotation
    gw = 2 * (x * (g[2, 1] - g[1, 2]) + y * (g[0, 2] - g[2, 0]) + z * (g[1, 0] - g[0, 1]))
    gx = 2 * (y * (g[0, 1] + g[1, 0]) + z * (g[0, 2] + g[2, 0]) + w * (g[2, 1] - g[1, 2])) - 4 * x * (
        g[1, 1] + g[2, 2]
    )
    gy = 2 * (x * (g[0, 1] + g[1, 0]) + z * (g[1, 2] + g[2, 1]) + w * (g[0, 2] - g[2, 0])) - 4 * y * (
        g[0, 0] + g[2, 2]
    )
    gz = 2 * (x * (g[0, 2] + g[2, 0]) + y * (g[1, 2] + g[2, 1]) + w * (g[1, 0] - g[0, 1])) - 4 * z * (
        g[0, 0] + g[1, 1]
    )
    along = gw * w + gx * x + gy * y + gz * z
    out[0], out[1] = (gw - along * w) / length, (gx - along * x) / length
    out[2], out[3] = (gy - along * y) / length, (gz - along * z) / length


@njit(forceinline=True, error_model="numpy")
def _axes_gradient(
    local: FloatArray,
    view: FloatArray,
    rotation: FloatArray,
    scale: NDArray[np.float32],
    by_axes: FloatArray,  # (2, 3)
    by_rotation: FloatArray,  # (3, 3), out
    by_scale: FloatArray,  # (3,), out
    by_local: FloatArray,  # (3,), added to
) -> None:
    """Backward of `_screen_axes`."""
    z = local[2]
    across = min(max(local[0] / z, view[4]), view[5])
    down = min(max(local[1] / z, view[6]), view[7])
    focal_x, focal_y = view[0] / z, view[1] / z
    by_across = by_down = by_z = 0.0
    for j in range(3):
        depth = view[17] * rotation[0, j] + view[18] * rotation[1, j] + view[19] * rotation[2, j]
        left = view[9] * rotation[0, j] + view[10] * rotation[1, j] + view[11] * rotation[2, j]
        top = view[13] * rotation[0, j] + view[14] * rotation[1, j] + view[15] * rotation[2, j]
        row_x, row_y = left - across * depth, top - down * depth
        gx, gy = by_axes[0, j] * focal_x, by_axes[1, j] * focal_y
        by_scale[j] = gx * row_x + gy * row_y
        gx, gy = gx * scale[j], gy * scale[j]
        by_z -= (gx * row_x + gy * row_y) / z
        by_across -= gx * depth
        by_down -= gy * depth
        for k in range(3):
            by_rotation[k, j] = gx * (view[9 + k] - across * view[17 + k]) + gy * (
                view[13 + k] - down * view[17 + k]
            )
    if across == local[0] / z:
        by_local[0] += by_across / z
        by_z -= by_across * across / z
    if down == local[1] / z:
        by_local[1] += by_down / z
        by_z -= by_down * down / z
    by_local[2] += by_z


@njit(parallel=True, cache=True, error_model="numpy")
def project_backward(
    means: NDArray[np.float32],
    quats: NDArray[np.float32],
    scales: NDArray[np.float32],
    opacities: NDArray[np.float32],
    view: FloatArray,
    compensated: bool,
    seen: NDArray[np.bool_],  # (N,) splats with gradient sums
    sums: NDArray[np.float32],  # (N, SUM_SIZE)
    by_means: NDArray[np.float32],  # (N, 3), out
    by_quats: NDArray[np.float32],  # (N, 4), out
    by_scales: NDArray[np.float32],  # (N, 3), out
    by_opacities: NDArray[np.float32],  # (N,), out
) -> None:
    """Gradients by the activated parameters from the raster's sums; zero where a splat is not seen."""
    for n in prange(means.shape[0]):
        if not seen[n]:
            by_means[n] = 0.0
            by_quats[n] = 0.0
            by_scales[n] = 0.0
            by_opacities[n] = 0.0
            continue
        rotation, local, axes = stack_array64(3, 3), stack_array64(3), stack_array64(2, 3)
        by_cov, by_axes, by_rotation = stack_array64(3), stack_array64(2, 3), stack_array64(3, 3)
        by_scale, by_local = stack_array64(3), stack_array64(3)
        by_local[0] = by_local[1] = by_local[2] = 0.0
        _to_camera(means[n], view, local)
        _rotation(quats[n], rotation)
        _screen_axes(local, view, rotation, scales[n], axes)
        xx, xy, yy, determinant = _covariance(axes)
        total = sums[n]
        _conic_gradient(total, xx, xy, yy, determinant, by_cov)
        for j in range(3):
            by_axes[0, j] = 2 * (by_cov[0] * axes[0, j] + by_cov[1] * axes[1, j])
            by_axes[1, j] = 2 * (by_cov[1] * axes[0, j] + by_cov[2] * axes[1, j])
        if compensated:
            _add_compensation_gradient(axes, xx, xy, yy, determinant, np.float64(total[SUM_Q]), by_axes)
        _axes_gradient(local, view, rotation, scales[n], by_axes, by_rotation, by_scale, by_local)
        by_u = (yy * total[SUM_QX] - xy * total[SUM_QY]) / determinant
        by_v = (xx * total[SUM_QY] - xy * total[SUM_QX]) / determinant
        z = local[2]
        by_local[0] += view[0] / z * by_u
        by_local[1] += view[1] / z * by_v
        by_local[2] += total[SUM_DEPTH] - (view[0] * local[0] * by_u + view[1] * local[1] * by_v) / (z * z)
        for k in range(3):
            by_means[n, k] = (
                view[9 + k] * by_local[0] + view[13 + k] * by_local[1] + view[17 + k] * by_local[2]
            )
            by_scales[n, k] = by_scale[k]
        _quaternion_gradient(quats[n], by_rotation, by_quats[n])
        by_opacities[n] = total[SUM_Q] / opacities[n]


@njit(parallel=True, cache=True, error_model="numpy")
def center_gradients(
    records: NDArray[np.float32],  # (N, RECORD_SIZE)
    sums: NDArray[np.float32],  # (N, SUM_SIZE)
    seen: NDArray[np.bool_],  # (N,)
    by_centers: NDArray[np.float32],  # (N, 2), out
) -> None:
    """Gradient by the centres on screen, in pixels, from the raster's sums; 0 where a splat is not seen."""
    two = np.float32(2.0)
    # The moments are of offsets from the centre to the pixels, hence the signs.
    for n in prange(len(seen)):
        by_centers[n] = 0.0
        if seen[n]:
            record, total = records[n], sums[n]
            shear = record[SHEAR]
            by_x = two * record[ACROSS] * (total[SUM_QX] + shear * total[SUM_QY])
            by_centers[n, 0] = -LN_2 * by_x
            by_centers[n, 1] = -LN_2 * (shear * by_x + two * record[DOWN] * total[SUM_QY])
