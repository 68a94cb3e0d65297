"""The surface of a sheet whose place is known at every time, through a fixed and through a moving camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.clip import Frame
from renderer.measuring.surface_accuracy import depth_distances
from renderer.phantom import Phantom, PhantomParams
from renderer.surface.fineness import Fineness
from renderer.surface.following import Follower
from renderer.surface.height_field import height_field
from renderer.surface.maps import Maps, read
from renderer.surface.mesh import Mesh
from renderer.surface.of_model import REFERENCE, looked_through, surface_of
from tests.renderer.surface.phantom_errors import material, surface_errors
from tests.renderer.surface.sheets import CAMERA, HOLE, NEAR, SLOPE, WAY, around, depth_at, sheet

MODEL = sheet()


@pytest.fixture(scope="module", params=["fixed", "moving"])
def follower(request: pytest.FixtureRequest) -> Follower:
    cameras: tuple[Camera, ...] = (CAMERA,) * 5 if request.param == "fixed" else around(5)
    return surface_of(MODEL, cameras, NEAR, fineness=Fineness(vertices=3000))


@pytest.mark.parametrize("time", [0.0, REFERENCE, 1.0])
def test_every_vertex_lies_on_the_sheet_at_every_time(follower: Follower, time: float) -> None:
    mesh = follower.at(time)
    points = mesh.vertices.astype(float)
    assert len(points) > 1500
    # Expected depth is that of the centres of wide splats, which lie before what they show at a slant.
    assert np.abs(depth_at(points, time) - points[:, 2]).mean() < 0.2
    assert mesh.faces is follower.mesh.faces
    way = points - follower.mesh.vertices
    assert np.median(np.abs(way - (time - REFERENCE) * WAY), axis=0) == pytest.approx(0, abs=0.15)


def test_faces_look_at_the_cameras_and_what_was_never_seen_stays_a_hole(follower: Follower) -> None:
    mesh = follower.mesh
    assert (mesh.normals[:, 2] < 0).mean() > 0.99
    middle = np.array([0, 0, 50]) + REFERENCE * WAY
    away = np.hypot(*(mesh.vertices - middle).T[:2])
    assert 0.75 * HOLE < away.min() < 1.25 * HOLE
    assert (mesh.normals @ np.array([SLOPE, 0, -1]) / np.hypot(SLOPE, 1) > 0.98).mean() > 0.9


def test_colors_are_those_that_are_seen(follower: Follower) -> None:
    mesh = follower.at(0.0)
    left, right = mesh.vertices[:, 0] < -3, mesh.vertices[:, 0] > 3
    assert (mesh.colors[left, 0] > 0.7).mean() > 0.95
    assert (mesh.colors[right, 1] > 0.7).mean() > 0.95


def test_it_is_simplified_to_a_number_of_faces_and_follows_all_the_same() -> None:
    follower = surface_of(MODEL, (CAMERA,), NEAR, fineness=Fineness(vertices=3000, faces=400))
    assert 200 < len(follower.mesh.faces) <= 400
    points = follower.at(1.0).vertices.astype(float)
    assert np.abs(depth_at(points, 1.0) - points[:, 2]).mean() < 0.1


def test_a_step_in_depth_is_cut_and_specks_are_left_out() -> None:
    depth = np.full((72, 96), 50, np.float32)
    depth[:, 48:] = 20
    seen = np.ones(depth.shape, bool)
    seen[:, 30:40] = False
    seen[35:37, 34:36] = True
    maps = Maps(CAMERA, depth, seen, np.zeros((72, 96, 3), np.float32))
    mesh = height_field(maps, 1)
    corners = mesh.vertices[mesh.faces][:, :, 2]
    assert (np.ptp(corners, axis=1) == 0).all()
    assert len(mesh.faces) == 2 * 71 * (29 + 7 + 47)


def test_of_many_like_pieces_none_is_a_speck() -> None:
    corners = np.arange(3 * 144, dtype=np.int32).reshape(144, 3)
    vertices = np.random.default_rng(0).normal(size=(corners.size, 3)).astype(np.float32)
    mesh = Mesh(vertices, corners, np.zeros_like(vertices))
    assert len(mesh.without_specks().faces) == 144


def test_maps_are_read_between_pixels() -> None:
    ramp = np.add.outer(10 * np.arange(4.0), np.arange(5.0)).astype(np.float32)
    places = np.array([[0.5, 0.5], [2.25, 1.5], [2.5, 2.75], [99.0, -5.0]])
    assert read(ramp, places) == pytest.approx([0, 11.75, 24.5, 4])
    assert read(np.stack([ramp] * 3, axis=2), places)[:, 2] == pytest.approx([0, 11.75, 24.5, 4])


def test_few_cameras_stand_for_a_moving_one_and_one_for_a_fixed() -> None:
    assert looked_through((CAMERA,) * 40) == (0,)
    assert looked_through(around(3)) == (0, 1, 2)
    many = looked_through(around(60))
    assert (len(many), many[0], many[-1]) == (12, 0, 59)


def test_errors_are_those_that_were_put_in() -> None:
    surface = Phantom(PhantomParams(n_frames=8, width=64, height=48)).surface
    u, v = (axis.ravel() for axis in np.meshgrid(np.linspace(-15, 15, 40), np.linspace(-12, 12, 40)))
    place, along_u, along_v = surface.evaluate(u, v, 0.3)
    normal = np.cross(along_u, along_v)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    places = np.arange(1600).reshape(40, 40)
    a, b, c = (part.ravel() for part in (places[:-1, :-1], places[:-1, 1:], places[1:, :-1]))
    mesh = Mesh((place + 0.2 * normal).astype(np.float32), np.stack([a, b, c], 1).astype(np.int32),
                np.zeros((1600, 3), np.float32))  # fmt: skip
    owned = np.stack([u, v], axis=1)
    errors = surface_errors(mesh, surface, 0.3, owned)
    assert (errors.mean, errors.most) == (pytest.approx(0.2, abs=1e-4), pytest.approx(0.2, abs=1e-4))
    assert errors.normal < 2
    assert errors.drift < 1e-3
    assert np.abs(material(mesh.vertices, surface, 0.3) - owned).max() < 1e-3


def test_distances_to_measured_depth_are_along_the_normal_and_on_tissue_alone() -> None:
    tissue = np.ones((72, 96), bool)
    tissue[:, :48] = False
    slanted = np.arange(96) * np.float32(0.2) + np.zeros((72, 1), np.float32) + 40
    depth = np.where(tissue, slanted, 0).astype(np.float32)
    maps = Maps(CAMERA, slanted + np.float32(0.5), np.ones((72, 96), bool), np.zeros((72, 96, 3), np.float32))
    mesh = height_field(maps, 3)
    frame = Frame(0, 0.0, np.zeros((72, 96, 3), np.uint8), CAMERA, tissue, tissue, depth)
    found = depth_distances(mesh, frame)
    seen = CAMERA.project(mesh.vertices.astype(float))[0][:, 0] > 48.5
    assert 0.85 * np.count_nonzero(seen) < len(found) <= np.count_nonzero(seen)
    # A surface that falls away by 0.2 a pixel, of 0.4 across, is nearer than along the line of sight.
    assert 0.3 < found.mean() < 0.5
    assert len(depth_distances(mesh, replace(frame, depth=None))) == 0


@pytest.mark.parametrize("wrong", [-1, 3])
def test_a_face_of_a_vertex_that_there_is_not_is_named(wrong: int) -> None:
    corners = np.eye(3, dtype=np.float32)
    with pytest.raises(ValueError, match=f"expected faces of 3 vertices, got number {wrong}$"):
        Mesh(corners, np.array([[0, 1, wrong]], np.int32), corners)
