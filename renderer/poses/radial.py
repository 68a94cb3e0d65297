"""Radial distortion by one number, as k1 of OpenCV: what a lens without it shows at a slant s from its axis,
one with it shows at s (1 + k1 |s|^2)."""

from __future__ import annotations

import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.poses.rigid_motion import lens_slopes, projected, slopes

_ROUNDS = 40
_LEAST = 0.3
"""Of a length, that the lens leaves: beyond, its polynomial turns back."""


def bent(lens: Camera, seen: FloatArray, k1: float) -> FloatArray:
    """Where a lens with distortion shows what one without shows at `seen`: (N, 2) or (N, 3), column and row
    in px first."""
    if not k1:
        return seen
    slants = _slants(lens, seen)
    shown = seen.copy()
    shown[:, :2] += k1 * (slants**2).sum(axis=1, keepdims=True) * slants * (lens.fx, lens.fy)
    return shown


def straightened(lens: Camera, places: FloatArray, k1: float) -> FloatArray:
    """Inverse of `bent` for (N, 2) px, by a fixed point."""
    slants = seen = _slants(lens, places)
    for _ in range(_ROUNDS):
        slants = seen / np.maximum(1 + k1 * (slants**2).sum(axis=1, keepdims=True), _LEAST)
    return np.asarray(slants * (lens.fx, lens.fy) + (lens.cx, lens.cy))


def bent_slopes(lens: Camera, places: FloatArray, k1: float) -> tuple[FloatArray, FloatArray]:
    """How `bent` of `projected` changes with the places (N, 3) in camera axes, (N, 3, 3), and with the
    logarithm of the focal length and k1, (N, 3, 2)."""
    by_place, by_lens = slopes(lens, places), np.zeros((len(places), 3, 2))
    by_lens[:, :, 0] = lens_slopes(lens, places)
    slants = _slants(lens, projected(lens, places))
    squares = (slants**2).sum(axis=1, keepdims=True)
    focal = np.array([lens.fx, lens.fy])
    by_lens[:, :2, 1] = squares * slants * focal
    if k1:
        by_lens[:, :2, 0] *= 1 + k1 * squares
        bending = 2 * k1 * slants[:, :, None] * slants[:, None, :] + (1 + k1 * squares)[:, :, None] * np.eye(
            2
        )
        by_place[:, :2] = (bending * (focal[:, None] / focal)) @ by_place[:, :2]
    return by_place, by_lens


def _slants(lens: Camera, seen: FloatArray) -> FloatArray:
    return np.asarray((seen[:, :2] - (lens.cx, lens.cy)) / (lens.fx, lens.fy))
