"""Where the sides of a camera's image cut splats off: nothing is drawn of what it did not have in view.

A splat that a side crosses is cut along a line of the picture. Behind a pixel at offset d from its centre,
the likeliest point of the Gaussian is mean + R S A' C^-1 d, where A = J W R S and C = A A' + low-pass (Eqs
14, 15): linear in d, so the distance to a plane is, too, and divided by its slope it is in pixels. Alpha
falls to 0 over one pixel, half a pixel to either side of that line.
"""

from __future__ import annotations

import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.projection import LOW_PASS, camera_vector
from renderer.rotations import matrix
from renderer.splats import Float32Array, Splats

REACH = 3.4
"""Standard deviations within which alpha can be above the cut."""
LEAST_SLOPE = 1e-20
"""Scene units a pixel: a splat without extent along the plane's normal lies on one side of it."""


def margins(splats: Splats, within: Camera) -> Float32Array:
    """(N,) how far a splat lies within the image's sides, in its own greatest reach: below -1 it lies wholly
    beyond one of them, above 1 none crosses it."""
    sides = within.sides.astype(np.float32)
    distances = (splats.means @ sides[:, :3].T + sides[:, 3]).min(axis=1)
    reach = np.float32(REACH) * np.abs(splats.scales).max(axis=1)
    margin: Float32Array = np.divide(distances, reach, out=2 * np.sign(distances), where=reach > 0)
    return margin


def crossings(
    means: FloatArray, quats: FloatArray, scales: FloatArray, camera: Camera, within: Camera
) -> FloatArray:
    """(N, 4, 3): pixels to the line where a splat crosses each side, at its centre, and what they grow by a
    pixel to the right and a pixel down. For N splats in front of the camera, in float64."""
    view, pose = camera_vector(camera, 1.0), camera.camera_from_world
    turns = matrix(_unit(quats).T).transpose(2, 0, 1)
    local = means @ pose[:3, :3].T + pose[:3, 3]
    slopes = np.clip(local[:, :2] / local[:, 2:], view[[4, 6]], view[[5, 7]])
    spread = pose[:3, :3] @ turns * scales[:, None, :]
    focal = view[:2] / local[:, 2:]
    axes = focal[:, :, None] * (spread[:, :2] - slopes[:, :, None] * spread[:, 2:])
    along = axes @ ((within.sides[:, :3] @ turns) * scales[:, None, :]).transpose(0, 2, 1)
    growth = _solved(axes, along).transpose(0, 2, 1)
    distances = means @ within.sides[:, :3].T + within.sides[:, 3]
    steepness = np.maximum(np.linalg.norm(growth, axis=2), LEAST_SLOPE)
    lines: FloatArray = np.concatenate([distances[..., None], growth], axis=2) / steepness[..., None]
    return lines


def _solved(axes: FloatArray, along: FloatArray) -> FloatArray:
    """(N, 2, K) C^-1 `along`, of C = A A' + low-pass with A = `axes` (N, 2, 3); a needle of any length, seen
    with 0 as its own determinant, has one by the low-pass."""
    (xx, xy), (_, yy) = (axes @ axes.transpose(0, 2, 1)).transpose(1, 2, 0)
    sharp = (np.cross(axes[:, 0], axes[:, 1]) ** 2).sum(axis=1)
    determinants = sharp + LOW_PASS * (xx + yy + LOW_PASS)
    shear, across = (xy / (xx + LOW_PASS))[:, None], (xx + LOW_PASS)[:, None]
    down = (along[:, 1] - shear * along[:, 0]) * (across / determinants[:, None])
    return np.stack([along[:, 0] / across - shear * down, down], axis=1)


def _unit(quats: FloatArray) -> FloatArray:
    """The zero quaternion is the identity."""
    quats = np.where((quats == 0).all(axis=1, keepdims=True), [1.0, 0.0, 0.0, 0.0], quats)
    unit: FloatArray = quats / np.linalg.norm(quats, axis=1, keepdims=True)
    return unit
