"""Where a second camera is, from what both see, up to scale; and whether that can be told."""

from __future__ import annotations

import math
from typing import Any, Final

import cv2
import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.poses.resection import trust
from renderer.poses.rigid_motion import projected, zoomed

CERTAIN_PX: Final = 1.0
"""px, from which on a point contradicts a geometry."""
_FOCALS = (-0.5, -0.25, 0.0, 0.25, 0.5)
"""Logarithms of factors to a focal length that is guessed, in which a mere turn is looked for."""
WIDER: Final = tuple(-0.0625 * step for step in range(7, 19))
"""Those of lenses that are wider by far than the guess, as of endoscopes. What a shift does to a flat wall
looks like a turn through narrow ones, which are therefore not looked at."""
_ROUNDS, _ZOOM_ROUNDS = 6, 12


def parallax(lens: Camera, one: FloatArray, other: FloatArray, focal_is_known: bool) -> float:
    """Median distance in px of the points (N, 2) of two views that is left when the second view is turned to
    the first: 0 when the camera only turns, small when it hardly moves from its place."""
    steps = (0.0,) if focal_is_known else _FOCALS
    return min(_after_turn(zoomed(lens, step), one, other) for step in steps)


def parallax_beside_zoom(lens: Camera, one: FloatArray, other: FloatArray, focal_is_known: bool) -> float:
    """As `parallax`, where the second view may have a longer or shorter focal length: also small when the
    camera moves straight towards a flat wall, which looks the same."""
    steps = (0.0,) if focal_is_known else _FOCALS
    return min(_after_turn(zoomed(lens, step), one, other, zooms=True) for step in steps)


def second_poses(lens: Camera, one: FloatArray, other: FloatArray) -> list[FloatArray]:
    """Poses (4, 4), camera from first camera, that two views (N, 2) may have, with a shift of length 1.

    One from the essential matrix, and those from the homography, which is the surer one on a plane
    (OpenCV: MAGSAC++ of Barath et al., 2020; decompositions by Nister, 2004, and Malis and Vargas, 2007).
    """
    return [*_by_essential(lens, one, other), *_by_homography(lens, one, other)]


def _by_essential(lens: Camera, one: FloatArray, other: FloatArray) -> list[FloatArray]:
    found: Any
    try:
        found, agree = cv2.findEssentialMat(
            one, other, lens.intrinsics, method=cv2.USAC_MAGSAC, prob=0.9999, threshold=CERTAIN_PX
        )
    except cv2.error:  # Points from which no geometry follows.
        return []
    if found is None or found.shape != (3, 3):
        return []
    _, turn, shift, _ = cv2.recoverPose(found, one, other, lens.intrinsics, mask=agree.copy())
    return _poses([(turn, shift)])


def _by_homography(lens: Camera, one: FloatArray, other: FloatArray) -> list[FloatArray]:
    found: Any
    try:
        found, _ = cv2.findHomography(
            one, other, cv2.USAC_MAGSAC, CERTAIN_PX, maxIters=2000, confidence=0.9999
        )
    except cv2.error:
        return []
    if found is None or found.shape != (3, 3):
        return []
    _, turns, shifts, _ = cv2.decomposeHomographyMat(found, lens.intrinsics)
    return _poses(list(zip(turns, shifts, strict=True)))


def _poses(found: list[tuple[Any, Any]]) -> list[FloatArray]:
    poses = []
    for turn, shift in found:
        length = np.linalg.norm(shift)
        if np.isfinite(turn).all() and np.isfinite(length) and length > 0:
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = turn, shift[:, 0] / length
            poses.append(pose)
    return poses


def rays(lens: Camera, places: FloatArray) -> FloatArray:
    """(N, 3) of length 1 in camera axes, through places (N, 2) in px."""
    x, y = (places[:, 0] - lens.cx) / lens.fx, (places[:, 1] - lens.cy) / lens.fy
    found = np.stack([x, y, np.ones_like(x)], axis=1)
    return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))


def _after_turn(lens: Camera, one: FloatArray, other: FloatArray, *, zooms: bool = False) -> float:
    """The turn, and the zoom, is that of most points: weights follow what is left over."""
    here, second = rays(lens, one), lens
    weights, left = np.ones(len(one)), np.zeros(len(one))
    for _ in range(_ZOOM_ROUNDS if zooms else _ROUNDS):
        there = rays(second, other)
        u, _, vt = np.linalg.svd(there.T @ (weights[:, None] * here))
        turn = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt
        left = second.fx * np.linalg.norm(here @ turn.T - there, axis=1)
        weights = trust((left / max(float(np.median(left)), 1e-9)) ** 2)
        if zooms:
            second = zoomed(second, _growth(second, here @ turn.T, other, weights))
    return float(np.median(left))


def _growth(lens: Camera, turned: FloatArray, other: FloatArray, weights: FloatArray) -> float:
    """Logarithm of how much larger than expected the second view shows what lies along rays (N, 3)."""
    middle = np.array([lens.cx, lens.cy])
    expected, seen = projected(lens, turned)[:, :2] - middle, other - middle
    across = weights @ (expected * seen).sum(axis=1) / max(weights @ (expected**2).sum(axis=1), 1e-9)
    return math.log(min(max(across, 0.5), 2.0))
