"""Rotations as unit quaternions (4,) wxyz: products, logarithms, and a cubic through them.

The cubic is the cumulative form of Hermite's: M.-J. Kim, M.-S. Kim, S. Y. Shin, "A general construction
scheme for unit quaternion curves with simple high order derivatives", SIGGRAPH 1995.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from renderer.camera import FloatArray


def turned_hermite(
    turns: FloatArray, speeds: FloatArray, a: int, b: int, share: float, step: float
) -> FloatArray:
    """Of the cubic (4,), at `share` in [0, 1] of the way from keyframe a to b, which are `step` s apart.

    `turns` are unit quaternions (K, 4) wxyz, `speeds` (K, 3) in radians a second, in the turned body's axes.
    """
    s = share
    leave, arrive = exponential(step / 3 * speeds[a]), exponential(step / 3 * speeds[b])
    middle = product(product(conjugate(leave), product(conjugate(turns[a]), turns[b])), conjugate(arrive))
    turn = product(turns[a], exponential((1 - (1 - s) ** 3) * step / 3 * speeds[a]))
    turn = product(turn, exponential((3 - 2 * s) * s * s * logarithm(middle)))
    return product(turn, exponential(s**3 * step / 3 * speeds[b]))


def quaternion(rotation: FloatArray) -> FloatArray:
    """Unit wxyz of a rotation matrix, by its largest component: never a division by nearly 0."""
    m = rotation
    products = np.array(
        [
            [1 + m[0, 0] + m[1, 1] + m[2, 2], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], 1 + m[0, 0] - m[1, 1] - m[2, 2], m[1, 0] + m[0, 1], m[0, 2] + m[2, 0]],
            [m[0, 2] - m[2, 0], m[1, 0] + m[0, 1], 1 - m[0, 0] + m[1, 1] - m[2, 2], m[2, 1] + m[1, 2]],
            [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[2, 1] + m[1, 2], 1 - m[0, 0] - m[1, 1] + m[2, 2]],
        ]
    )
    row = products[int(np.argmax(np.diag(products)))]
    return np.asarray(row / np.linalg.norm(row))


def matrix(turn: FloatArray) -> FloatArray:
    """(3, 3) of a unit quaternion (4,) wxyz; (3, 3, N) of (4, N)."""
    w, x, y, z = turn
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def product(a: FloatArray, b: FloatArray) -> FloatArray:
    """First b, then a."""
    vector = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.asarray(np.r_[a[0] * b[0] - a[1:] @ b[1:], vector])


def conjugate(a: FloatArray) -> FloatArray:
    return np.asarray(np.r_[a[0], -a[1:]])


def exponential(rotation: FloatArray) -> FloatArray:
    """Unit quaternion of a rotation vector (3,) in radians."""
    half = rotation / 2
    angle = float(np.linalg.norm(half))
    return np.asarray(np.r_[math.cos(angle), np.sinc(angle / math.pi) * half])


def logarithm(turn: FloatArray) -> FloatArray:
    """Rotation vector (3,) of the shorter way: q and -q are one rotation, so a keyframe's sign is no flip."""
    w, sine = abs(float(turn[0])), float(np.linalg.norm(turn[1:]))
    toward = turn[1:] if turn[0] >= 0 else -turn[1:]
    return np.asarray(2 * toward * (math.atan2(sine, w) / sine if sine > 1e-12 else 1.0))


def unit_quats(quats: NDArray[np.float32]) -> NDArray[np.float32]:
    """(N, 4) wxyz of length 1 with w >= 0; the identity in place of no rotation."""
    length = np.linalg.norm(quats, axis=1, keepdims=True)
    unit = np.divide(quats, length, out=np.zeros_like(quats), where=length > 0)
    unit[length[:, 0] == 0, 0] = 1
    return np.asarray(unit * np.where(unit[:, :1] < 0, -1, 1), np.float32)


def of_nearer_sign(quats: NDArray[Any], others: NDArray[Any]) -> NDArray[Any]:
    """(N, 4) the same turns, each of the sign nearer to that of the others, so that what goes straight from
    one to the next takes the short way."""
    return np.where((quats * others).sum(axis=1, keepdims=True) < 0, -quats, quats)
