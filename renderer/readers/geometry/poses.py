"""Poses as clip files write them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from renderer.camera import FloatArray
from renderer.rotations import matrix

ROUNDED: Final = 1e-6
"""Deviation from a rotation that float32 leaves: passed over."""
LARGEST_DEVIATION: Final = 0.05
"""Deviation from a rotation that rounding and drift explain; beyond, the matrix is none."""


@dataclass(frozen=True, eq=False)
class Rotations:
    """Matrices as files have them, made rotations."""

    matrices: FloatArray
    """(N, 3, 3)"""
    notices: tuple[str, ...]


def nearest_rotations(given: FloatArray, names: Sequence[str]) -> Rotations:
    """The rotations nearest to matrices (N, 3, 3), in the sense of Frobenius (Schönemann, 1966).

    How far a matrix R is from one is the largest element of |R R^T - 1|. Up to ROUNDED it stays as it is; up
    to LARGEST_DEVIATION it is mended, with a notice that has the size and the name, such as a frame's.

    Raises:
        ValueError: a larger deviation, or a mirror; the text has the size and the name.
    """
    away = np.abs(given @ given.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    worst = int(np.argmax(away))
    if away[worst] > LARGEST_DEVIATION:
        wanted = f"expected rotations, R R^T within {LARGEST_DEVIATION:g} of 1"
        raise ValueError(f"{wanted}, got {away[worst]:.2g} in {names[worst]}")
    mirrors = np.flatnonzero(np.linalg.det(given) < 0)
    if mirrors.size:
        raise ValueError(f"expected rotations, got a mirror in {names[int(mirrors[0])]}")
    odd = away > ROUNDED
    if not odd.any():
        return Rotations(given, ())
    left, _, right = np.linalg.svd(given)
    mended = np.where(odd[:, None, None], left @ right, given)
    said = f"{np.count_nonzero(odd)} of {len(given)} poses are not quite rotations, R R^T differs from 1"
    return Rotations(
        mended, (f"{said} by up to {away[worst]:.2g} in {names[worst]}: replaced by the nearest rotations",)
    )


def pose_matrix(position: FloatArray, xyzw: FloatArray) -> FloatArray:
    """The (4, 4) matrix of a position (3,) and a quaternion (4,) of any length above 0.

    Raises:
        ValueError: the quaternion is 0, or a number is not finite.
    """
    length = float(np.linalg.norm(xyzw))
    if not (0 < length < np.inf and np.isfinite(position).all()):
        given = f"{np.ravel(position).tolist()} and {np.ravel(xyzw).tolist()}"
        raise ValueError(f"expected a finite position and a quaternion other than 0, got {given}")
    pose = np.eye(4)
    pose[:3, 3] = position
    pose[:3, :3] = matrix(np.roll(xyzw / length, 1))
    return pose
