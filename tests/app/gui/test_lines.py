"""Lines of the world over a picture: cut off where they leave the front of the camera."""

from __future__ import annotations

import numpy as np
import pytest

from app.gui.views.lines import frustum, seen
from renderer.camera import Camera
from tests.renderer.scenes import turned_camera

CAMERA = turned_camera(64, 48)


def test_a_small_camera_spans_its_own_picture() -> None:
    """Its corners fall on the corners of what it sees itself, its edges on their edges."""
    segments = frustum(CAMERA, 3.0)
    pixels, depths = CAMERA.project(segments[:, 1])
    np.testing.assert_allclose(depths, 3.0)
    corners = [(0, 0), (64, 0), (64, 48), (0, 48)]
    np.testing.assert_allclose(pixels[:4], corners, atol=1e-9)
    np.testing.assert_allclose(pixels[4:8], [*corners[1:], corners[0]], atol=1e-9)
    np.testing.assert_allclose(pixels[8], (32, -12), atol=1e-9)
    np.testing.assert_allclose(segments[:4, 0], np.tile(CAMERA.position, (4, 1)), atol=1e-12)


def test_lines_end_where_they_are_seen_to() -> None:
    points = np.array([[-1.0, 2.0, 4.0], [3.0, 1.0, 9.0], [1.0, -1.0, -5.0]])
    world = CAMERA.world_from_camera
    ahead, farther, behind = points @ world[:3, :3].T + world[:3, 3]
    (one,) = seen(CAMERA, np.array([[ahead, farther]]), 0.1)
    np.testing.assert_allclose(one, CAMERA.project(np.array([ahead, farther]))[0])
    assert seen(CAMERA, np.array([[behind, behind - 0.1 * (ahead - behind)]]), 0.1).shape == (0, 2, 2)
    for order in ((ahead, behind), (behind, ahead)):
        (cut,) = seen(CAMERA, np.array([order]), 0.5)
        share = (4.0 - 0.5) / (4.0 + 5.0)
        wanted = CAMERA.project(np.array([ahead, ahead + share * (behind - ahead)]))[0]
        np.testing.assert_allclose(cut if order[0] is ahead else cut[::-1], wanted)


@pytest.mark.parametrize("camera", [CAMERA, turned_camera(320, 200)])
def test_a_camera_sees_its_own_eye_nowhere(camera: Camera) -> None:
    """Lines from the eye begin at the near plane, and are numbers."""
    lines = seen(camera, frustum(camera, 1.0), 0.01)
    assert np.isfinite(lines).all()
    assert len(lines) == 9
