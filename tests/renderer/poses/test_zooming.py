"""A lens that zooms while its camera moves is told by depth, and undone; one that does not is left alone."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.phantom import Phantom
from renderer.poses.bundle import Bundle, adjusted, misfit
from renderer.poses.radial import bent
from renderer.poses.rigid_motion import Seen, local, moved, projected, zoomed
from renderer.poses.search import find_poses
from renderer.poses.views import Rough, View
from renderer.poses.zooming import ONE_LENS, Zoom, zoom_undone
from tests.renderer.poses.test_search import COUNT, clip_of, drawn, errors, phantom

LENS = Camera.from_fov(60, 320, 256)
STEP = np.array([0.05, -0.08, 0.03, 0.2, -0.12, 0.06])
POINTS, VIEWS = 120, 24
NONE, EVEN = np.zeros(VIEWS), np.linspace(0, 0.3, VIEWS)


def points():
    return np.random.default_rng(3).uniform([-0.5, -0.4, 0.8], [0.5, 0.4, 1.3], (POINTS, 3))


def path():
    return np.stack([moved(np.eye(4), share * STEP) for share in np.sin(np.linspace(0, 2, VIEWS))])


def measured(longer, noise=0.0, move=lambda at: 0.0):
    """(VIEWS, POINTS, 3) what lenses that are longer by these logarithms see."""
    rng, shift = np.random.default_rng(1), np.array([noise, noise, 0.02 * noise])
    exact = [
        projected(zoomed(LENS, each), local(pose, points() + move(at)))
        for at, (each, pose) in enumerate(zip(longer, path(), strict=True))
    ]
    return np.stack(exact) + shift * rng.standard_normal((VIEWS, POINTS, 3))


def rough_of(longer, **changes):
    """As they are tracked: frames 3, 5, 7 ... of a clip."""
    weights = np.full((POINTS, 3), [2.0, 2.0, 50.0])
    views = tuple(
        View(3 + 2 * at, pose, np.arange(POINTS), Seen(there, weights), np.ones(POINTS, bool))
        for at, (pose, there) in enumerate(zip(path(), measured(longer, **changes), strict=True))
    )
    return Rough(LENS, views, tuple(range(0, VIEWS, 3)), points())


def bundle_of_zooming(longer, k1):
    """Off by a little from what is seen."""
    rng, middle = np.random.default_rng(2), np.array([LENS.cx, LENS.cy, 0])
    poses = [path()[0], *(moved(pose, 0.01 * rng.standard_normal(6)) for pose in path()[1:])]
    shown = np.stack([bent(LENS, projected(LENS, local(pose, points())), k1) for pose in path()])
    shown[..., :2] = (middle + (shown - middle) * np.exp(EVEN)[:, None, None])[..., :2]
    return Bundle(
        LENS, np.stack(poses), points() + 0.01 * rng.standard_normal((POINTS, 3)),
        np.repeat(np.arange(VIEWS), POINTS), np.tile(np.arange(POINTS), VIEWS),
        Seen(shown.reshape(-1, 3), np.full((VIEWS * POINTS, 3), [10, 10, 300.0])), k1=k1, longer=longer,
    )  # fmt: skip


@pytest.mark.parametrize("k1", [0.0, -0.2])
def test_each_view_gets_the_focal_length_by_which_it_sees(k1):
    """Of a lens that bends straight lines, too."""
    found = adjusted(bundle_of_zooming(0.9 * EVEN, k1), 60, 0.0)
    np.testing.assert_allclose(found.longer, EVEN, atol=1e-4)
    np.testing.assert_allclose(found.poses, path(), atol=1e-4)
    assert np.abs(misfit(found)).max() < 0.1
    assert found.longer[0] == 0


@pytest.mark.parametrize("longer", [EVEN, -EVEN, 0.05 * np.sin(np.linspace(0, 3, VIEWS))])
def test_a_zoom_is_found_and_undone(longer):
    zoom, rough = zoom_undone(rough_of(longer, noise=0.2))
    expected = longer - longer.min()
    assert [zoom.at(3 + 2 * at) for at in range(VIEWS)] == pytest.approx(expected, abs=0.005)
    assert zoom.grown == pytest.approx(np.expm1(expected.max()), abs=0.006)
    small, large = ((frame - 3) // 2 for frame in zoom.ends)
    assert longer[large] - longer[small] == pytest.approx(expected.max(), abs=0.006)
    one_lens = measured(NONE + longer.min(), noise=0.2)
    for view, there in zip(rough.views, one_lens, strict=True):
        np.testing.assert_allclose(view.seen.measured[:, :2], there[:, :2], atol=1.5)
    assert [view.frame for view in rough.views] == [3 + 2 * at for at in range(VIEWS)]


@pytest.mark.parametrize(
    "rough",
    [
        rough_of(NONE, noise=0.3),
        rough_of(NONE, noise=0.3, move=lambda at: np.array([0, 0, 0.03 * np.sin(at)])),
        rough_of(NONE, noise=0.3, move=lambda at: 0.03 * np.sin(at) * (points()[:, :1] > 0.1)),
        rough_of(0.1 * EVEN, noise=0.3),
        replace(rough_of(NONE, noise=0.3), lens=zoomed(LENS, 0.2)),
    ],
    ids=["rest", "all moves along the view", "a part is pulled", "by too little", "another focal length"],
)
def test_what_does_not_zoom_is_left_as_it_is(rough):
    assert zoom_undone(rough) == (ONE_LENS, rough)
    assert (ONE_LENS.grown, ONE_LENS.at(7)) == (0, 0)


def test_without_depth_or_points_no_zoom_is_looked_for():
    rough = rough_of(EVEN)
    blind = [
        replace(view, seen=replace(view.seen, weights=view.seen.weights * (1, 1, 0))) for view in rough.views
    ]
    none = [
        replace(view, ids=view.ids[:0], seen=Seen(np.zeros((0, 3)), np.zeros((0, 3)))) for view in rough.views
    ]
    for views in (blind, none):
        other = replace(rough, views=tuple(views))
        assert zoom_undone(other) == (ONE_LENS, other)


def test_between_frames_that_are_known_a_zoom_goes_evenly_and_stays_beyond():
    zoom = Zoom(np.array([4, 8]), np.array([0.0, 0.2]))
    assert [zoom.at(frame) for frame in (0, 4, 5, 8, 30)] == pytest.approx([0, 0, 0.05, 0.2, 0.2])


class Zooming(Phantom):
    """Its lens grows longer by a tenth."""

    def camera(self, index):
        return zoomed(super().camera(index), 0.1 * index / COUNT)


@cache
def zooming():
    return Zooming(phantom().params)


def test_the_path_of_a_camera_that_zooms_is_found_with_its_focal_lengths():
    """With one focal length 1.6 % of the path are left."""
    found = find_poses(clip_of(scene=zooming))
    assert (len(found.cameras), found.lost) == (COUNT, ())
    focal = [camera.fx / phantom().camera(0).fx for camera in found.cameras]
    assert focal == pytest.approx([np.exp(0.1 * at / COUNT) for at in range(COUNT)], abs=0.01)
    assert found.zoom.grown == pytest.approx(max(focal) - 1)
    assert found.zoom.ends == (0, COUNT - 1)
    off, angles = errors(found)
    assert np.sqrt(np.mean(off**2)) < 0.005
    assert angles.max() < 0.5


def test_of_the_phantom_without_a_zoom_all_cameras_have_its_lens():
    found = find_poses(clip_of())
    assert found.zoom is ONE_LENS
    assert {camera.fx for camera in found.cameras} == {drawn(0).camera.fx}
