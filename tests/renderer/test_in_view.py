"""The field of view in a dark surround as a convex outline, and as planes through the camera."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from renderer.camera import Camera, FloatArray
from renderer.in_view import IMAGE_SIDES, MOST_CORNERS, FieldInView, outline_of
from tests.renderer.scenes import turned_camera


def disc(radius: float, size: int, middle: tuple[float, float]) -> NDArray[np.bool_]:
    y, x = np.mgrid[:size, :size] + 0.5
    return np.asarray(np.hypot(x - middle[0], y - middle[1]) < radius)


def along(outline: FloatArray) -> FloatArray:
    """(P, 2) points of its sides."""
    share = np.linspace(0, 1, 40)[:, None, None]
    return (outline * (1 - share) + np.roll(outline, -1, axis=0) * share).reshape(-1, 2)


@pytest.mark.parametrize("radius", [1.5, 12.0, 100.0, 262.0, 540.0])
def test_a_round_field_is_told_to_half_a_pixel(radius: float) -> None:
    middle = (radius + 7.3, radius + 3.9)
    outline = outline_of(disc(radius, int(2 * radius + 20), middle))
    assert outline is not None
    assert 3 <= len(outline) <= MOST_CORNERS
    assert np.abs(np.hypot(*(along(outline) - middle).T) - radius).max() < 0.5


def test_straight_sides_and_those_of_the_image_stay_where_they_are() -> None:
    kept = np.ones((60, 80), bool)
    kept[50:] = False
    outline = outline_of(kept)
    assert outline is not None
    least, most = outline.min(axis=0), outline.max(axis=0)
    assert np.allclose((*least, *most), (0, 0, 80, 50))
    assert np.abs(np.minimum(along(outline) - least, most - along(outline)).min(axis=1)).max() < 0.4


def test_all_nothing_and_holes_are_no_field() -> None:
    kept = np.ones((30, 40), bool)
    assert outline_of(kept) is None
    kept[10:20, 10:30] = False
    assert outline_of(kept) is None
    assert outline_of(np.zeros((30, 40), bool)) is None


def test_a_field_of_one_pixel_is_one() -> None:
    kept = np.zeros((30, 40), bool)
    kept[12, 17] = True
    outline = outline_of(kept)
    assert outline is not None
    assert np.abs(outline - (17.5, 12.5)).max() <= 0.5
    sides = FieldInView(Camera.from_fov(60, 40, 30), outline).sides
    assert np.isfinite(sides).all()


def test_sides_hold_what_projects_into_the_outline() -> None:
    camera = turned_camera(90, 70)
    middle, radius = np.array([camera.width, camera.height]) / 2, 0.4 * camera.height
    angles = np.arange(8) * np.pi / 4
    corners = middle + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    sides = FieldInView(camera, np.concatenate([corners, corners[-1:]])).sides  # The last corner twice.
    assert len(sides) == IMAGE_SIDES + 8
    assert np.array_equal(sides[:IMAGE_SIDES], camera.sides)
    assert np.allclose(np.linalg.norm(sides[:, :3], axis=1), 1)
    points = camera.position + np.random.default_rng(5).normal(size=(5000, 3)) * 10
    pixels, depths = camera.project(points)
    reach = np.stack([np.cos(angles + np.pi / 8), np.sin(angles + np.pi / 8)], axis=1)
    falls = (depths > 0) & (((pixels - middle) @ reach.T).max(axis=1) <= radius * np.cos(np.pi / 8))
    distances = points @ sides[:, :3].T + sides[:, 3]
    assert np.array_equal((distances >= 0).all(axis=1), falls)
    assert 50 < falls.sum() < 4000
