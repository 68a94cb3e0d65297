"""The rotation and shift that best take one set of points to another."""

from __future__ import annotations

import numpy as np

from renderer.camera import FloatArray

_ROUNDS = 20
_SMALLEST = 1e-12  # Of a median misfit: exact matches have none to weigh by.


def rigid_fit(points: FloatArray, moved: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation (3, 3) and shift (3,) with moved ~ points @ rotation.T + shift, both (N, 3), N >= 3.

    Least squares (Arun, Huang and Blostein, 1987), weighted anew by Geman and McClure's function of
    the misfit over its median, so that a minority of other motions has no say.
    """
    weights = np.ones(len(points))
    rotation, shift = np.eye(3), np.zeros(3)
    for _ in range(_ROUNDS):
        share = weights / weights.sum()
        middle, middle_moved = share @ points, share @ moved
        u, _, vt = np.linalg.svd((points - middle).T @ ((moved - middle_moved) * share[:, None]))
        no_mirror = np.diag([1.0, 1.0, np.sign(np.linalg.det(vt.T @ u.T))])
        rotation = vt.T @ no_mirror @ u.T
        shift = middle_moved - rotation @ middle
        misfit = np.linalg.norm(points @ rotation.T + shift - moved, axis=1)
        scale = 1.5 * max(float(np.median(misfit)), _SMALLEST)
        weights = 1 / (1 + (misfit / scale) ** 2) ** 2
    return rotation, shift
