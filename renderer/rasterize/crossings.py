"""Where the sides of a camera's image or field of view cut splats off: nothing is drawn of what it did not
have in view.

A splat that a side crosses is cut along a line of the picture. Behind a pixel at offset d from its centre,
the likeliest point of the Gaussian is mean + R S A' C^-1 d, where A = J W R S and C = A A' + low-pass (Eqs
14, 15): linear in d, so the distance to a plane is, too, and divided by its slope it is in pixels. Alpha
falls to 0 over one pixel, half a pixel to either side of that line.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange

from renderer.camera import Camera, FloatArray
from renderer.in_view import IMAGE_SIDES, InView
from renderer.projection import LOW_PASS, camera_vector
from renderer.rotations import matrix
from renderer.splats import Float32Array, Splats

REACH = 3.4
"""Standard deviations within which alpha can be above the cut."""
NEAREST = 2
"""Of the sides of a field those by which a splat is cut: it is small beside the field, and one corner of a
convex outline has two."""
LONGEST = 1e5
"""Pixels; of one that is longer, the directions on screen are told apart first."""
LEAST_SLOPE = 1e-20
"""Scene units a pixel: a splat without extent along the plane's normal lies on one side of it."""


def margins(splats: Splats, within: InView) -> Float32Array:
    """(N,) how far a splat lies within the sides, in its own greatest reach: below -1 it lies wholly beyond
    one of them, above 1 none crosses it."""
    sides = within.sides.astype(np.float32)
    distances = (splats.means @ sides[:IMAGE_SIDES, :3].T + sides[:IMAGE_SIDES, 3]).min(axis=1)
    if len(sides) > IMAGE_SIDES:
        field = np.empty_like(distances)
        _find_least(splats.means, np.ascontiguousarray(sides[IMAGE_SIDES:].T), field)
        distances = np.minimum(distances, field)
    reach = np.float32(REACH) * np.abs(splats.scales).max(axis=1)
    margin: Float32Array = np.divide(distances, reach, out=2 * np.sign(distances), where=reach > 0)
    return margin


@njit(parallel=True, cache=True, fastmath={"contract", "reassoc", "nnan"}, error_model="numpy")
def _find_least(
    means: Float32Array,
    sides: Float32Array,  # (4, K)
    distances: Float32Array,  # (N,) to the nearest of them, out; of a splat that has no place, any
) -> None:
    for i in prange(len(means)):
        x, y, z = means[i, 0], means[i, 1], means[i, 2]
        least = np.float32(np.inf)
        for side in range(sides.shape[1]):
            distance = sides[0, side] * x + sides[1, side] * y + sides[2, side] * z + sides[3, side]
            least = min(least, distance)
        distances[i] = least


def crossings(
    means: FloatArray, quats: FloatArray, scales: FloatArray, camera: Camera, within: InView
) -> FloatArray:
    """(N, S, 3): pixels to the line where a splat crosses each side, at its centre, and what they grow by a
    pixel to the right and a pixel down. For N splats in front of the camera, in float64. S is 4, the sides of
    the image, or 6: with those of the field that are nearest to the centre."""
    view, pose = camera_vector(camera, 1.0), camera.camera_from_world
    turns = matrix(_unit(quats).T).transpose(2, 0, 1)
    local = means @ pose[:3, :3].T + pose[:3, 3]
    slopes = np.clip(local[:, :2] / local[:, 2:], view[[4, 6]], view[[5, 7]])
    spread = pose[:3, :3] @ turns * scales[:, None, :]
    focal = view[:2] / local[:, 2:]
    axes = focal[:, :, None] * (spread[:, :2] - slopes[:, :, None] * spread[:, 2:])
    normals, distances = _sides(means, within)
    reaches = ((normals @ turns) * scales[:, None, :]).transpose(0, 2, 1)
    growth = _solved(axes, axes @ reaches)
    lengths = (axes**2).sum(axis=(1, 2))
    needles = (lengths > LONGEST**2) & (lengths < np.inf)
    growth[needles] = _solved_apart(axes[needles], reaches[needles])
    growth = growth.transpose(0, 2, 1)
    steepness = np.maximum(np.linalg.norm(growth, axis=2), LEAST_SLOPE)
    lines: FloatArray = np.concatenate([distances[..., None], growth], axis=2) / steepness[..., None]
    return lines


def _sides(means: FloatArray, within: InView) -> tuple[FloatArray, FloatArray]:
    """Normals ((N,) S, 3) of the sides that may cut each splat, and distances (N, S) of its centre."""
    sides = within.sides
    normals, distances = sides[:, :3], means @ sides[:, :3].T + sides[:, 3]
    if len(sides) == IMAGE_SIDES:
        return normals, distances
    nearest = np.argpartition(distances[:, IMAGE_SIDES:], NEAREST - 1, axis=1)[:, :NEAREST] + IMAGE_SIDES
    image = np.broadcast_to(np.arange(IMAGE_SIDES), (len(means), IMAGE_SIDES))
    chosen = np.concatenate([image, nearest], axis=1)
    return normals[chosen], np.take_along_axis(distances, chosen, axis=1)


def _solved(axes: FloatArray, along: FloatArray) -> FloatArray:
    """(N, 2, K) C^-1 `along`, of C = A A' + low-pass with A = `axes` (N, 2, 3); a needle of any length, seen
    with 0 as its own determinant, has one by the low-pass."""
    (xx, xy), (_, yy) = (axes @ axes.transpose(0, 2, 1)).transpose(1, 2, 0)
    sharp = (np.cross(axes[:, 0], axes[:, 1]) ** 2).sum(axis=1)
    determinants = sharp + LOW_PASS * (xx + yy + LOW_PASS)
    shear, across = (xy / (xx + LOW_PASS))[:, None], (xx + LOW_PASS)[:, None]
    down = (along[:, 1] - shear * along[:, 0]) * (across / determinants[:, None])
    return np.stack([along[:, 0] / across - shear * down, down], axis=1)


def _solved_apart(axes: FloatArray, reaches: FloatArray) -> FloatArray:
    """The same by the singular values of A: of long splats `along` cancels, and no digit of it is left."""
    ways, lengths, apart = np.linalg.svd(axes, full_matrices=False)
    shares = lengths / (lengths**2 + LOW_PASS)
    growth: FloatArray = ways @ (shares[..., None] * (apart @ reaches))
    return growth


def _unit(quats: FloatArray) -> FloatArray:
    """The zero quaternion is the identity."""
    quats = np.where((quats == 0).all(axis=1, keepdims=True), [1.0, 0.0, 0.0, 0.0], quats)
    unit: FloatArray = quats / np.linalg.norm(quats, axis=1, keepdims=True)
    return unit
