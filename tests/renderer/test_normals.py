"""Where a surface faces, against planes and spheres whose normals are known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.normals import surface_normals

CAMERA = Camera(fx=210, fy=190, cx=70.3, cy=44.1, width=128, height=96)
Array = NDArray[np.float64]


def rays() -> Array:
    """(H, W, 3) through the middle of each pixel, one unit forward."""
    rows, columns = np.indices((CAMERA.height, CAMERA.width))
    x, y = (columns + 0.5 - CAMERA.cx) / CAMERA.fx, (rows + 0.5 - CAMERA.cy) / CAMERA.fy
    return np.stack([x, y, np.ones_like(x)], axis=2)


def plane(normal: Array, distance: float) -> NDArray[np.float32]:
    """Depth of the plane that stands at that distance before the camera."""
    return (-distance / (rays() @ normal)).astype(np.float32)


NORMALS = [(0, 0, -1), (0.6, 0, -0.8), (0, -0.6, -0.8), (0.3, -0.4, -0.866)]


@pytest.mark.parametrize("normal", NORMALS)
@pytest.mark.parametrize("distance", [1e-6, 0.4, 60.0, 1e6])
def test_of_a_plane_every_pixel_faces_as_it_does(normal: tuple[float, ...], distance: float) -> None:
    wanted = np.array(normal) / np.linalg.norm(normal)
    found = surface_normals(plane(wanted, distance), CAMERA)
    assert np.abs(found - wanted).max() < 2e-3
    assert np.linalg.norm(found, axis=2) == pytest.approx(1, abs=1e-5)


def test_a_hole_or_an_edge_bends_nothing() -> None:
    wanted = np.array([0.3, -0.4, -0.866])
    depth = plane(wanted / np.linalg.norm(wanted), 60.0)
    rows, columns = np.indices(depth.shape)
    seen = ((rows - 40) ** 2 + (columns - 60) ** 2 > 12**2) & (columns < 100)
    found = surface_normals(np.where(seen, depth, np.float32(0)), CAMERA)
    assert not found[~seen].any()
    assert np.abs(found[seen] - wanted / np.linalg.norm(wanted)).max() < 2e-3


def test_of_a_sphere_it_is_the_way_from_the_centre() -> None:
    centre, radius, way = np.array([1.0, -0.5, 12.0]), 4.0, rays()
    squared, along = (way**2).sum(axis=2), way @ centre
    inside = along**2 - squared * (centre @ centre - radius**2)
    depth = np.where(inside > 0, (along - np.sqrt(np.maximum(inside, 0))) / squared, 0).astype(np.float32)
    found, points = surface_normals(depth, CAMERA), way * depth[..., None]
    wanted = (points - centre) / radius
    facing = (depth > 0) & (-(wanted * way).sum(axis=2) / np.sqrt(squared) > 0.6)
    angles = np.degrees(np.arccos(np.clip((found * wanted).sum(axis=2)[facing], -1, 1)))
    assert facing.mean() > 0.2
    assert angles.max() < 2.0


def test_what_is_too_little_to_tell_is_zero() -> None:
    none = np.zeros((CAMERA.height, CAMERA.width), np.float32)
    assert not surface_normals(none, CAMERA).any()
    line = none.copy()
    line[30, 20:60] = 5.0
    assert not surface_normals(line, CAMERA).any()
    dot = none.copy()
    dot[30, 30] = 5.0
    assert not surface_normals(dot, CAMERA).any()
