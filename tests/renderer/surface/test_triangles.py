"""A mesh rendered: exact depth of a slanted triangle, the nearer one in front, colours in perspective."""

from __future__ import annotations

import numpy as np
import pytest

from renderer.surface.mesh import Mesh
from renderer.surface.triangles import render_mesh
from tests.renderer.surface.sheets import CAMERA


def slanted(depths: tuple[float, float, float], color: tuple[float, float, float]) -> Mesh:
    """Over the lower left of the frame."""
    pixels = np.array([[-20.0, -40.0], [-20.0, 100.0], [200.0, 100.0]])
    rays = np.stack([(pixels[:, 0] - 48) / 120, (pixels[:, 1] - 36) / 120, np.ones(3)], axis=1)
    vertices = (rays * np.array(depths)[:, None]).astype(np.float32)
    colors = np.tile(np.float32(color), (3, 1))
    return Mesh(vertices, np.array([[0, 1, 2]], np.int32), colors)


def test_depth_is_that_of_the_plane() -> None:
    mesh = slanted((40, 60, 55), (1, 0, 0))
    drawn = render_mesh(mesh, CAMERA, 0.1)
    normal = np.cross(mesh.vertices[1] - mesh.vertices[0], mesh.vertices[2] - mesh.vertices[0]).astype(float)
    points = CAMERA.unproject(np.ones((72, 96)))
    wanted = normal @ mesh.vertices[0] / (points @ normal)
    seen = drawn.alpha > 0
    assert 0.5 < seen.mean() < 1
    assert drawn.depth[seen] == pytest.approx(wanted[seen], rel=1e-5)
    assert not drawn.depth[~seen].any()
    assert not render_mesh(mesh, CAMERA, 41.0).alpha.any()


@pytest.mark.parametrize("order", [1, -1])
def test_the_nearer_triangle_is_seen_whatever_their_order(order: int) -> None:
    meshes = [slanted((40, 60, 60), (1, 0, 0)), slanted((60, 40, 60), (0, 1, 0))][::order]
    faces = np.concatenate([meshes[0].faces, meshes[1].faces + 3])
    both = Mesh(np.concatenate([one.vertices for one in meshes]), faces,
                np.concatenate([one.colors for one in meshes]))  # fmt: skip
    first, second = (render_mesh(one, CAMERA, 0.1) for one in meshes)
    drawn = render_mesh(both, CAMERA, 0.1)
    seen = drawn.alpha > 0
    assert drawn.depth[seen] == pytest.approx(np.minimum(first.depth, second.depth)[seen])
    nearer = (first.depth < second.depth)[..., None]
    assert drawn.image == pytest.approx(np.where(nearer, first.image, second.image), abs=1e-5)
