"""The phantom is its own ground truth, so its geometry is checked against independent reckoning."""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image
from pydantic import ValidationError

from assets import phantom_path
from renderer.camera import Camera
from renderer.clip import ClipError
from renderer.metrics import psnr
from renderer.phantom import Phantom, PhantomParams, View, write_phantom
from renderer.phantom.surface import grow_surface
from renderer.phantom.tissue import paint_tissue
from renderer.phantom.tools import Capsule, hit_tools
from renderer.phantom.vessels import grow_vessels
from renderer.readers.data_sets.scared import BASELINE
from renderer.sources import open_clip

N = 12
SMALL = {"n_frames": 2, "width": 48, "height": 32}
KINDS = {"fixed": ("fixed", "moving"), "moving camera": ("moving", "static"), "both": ("moving", "moving")}


@pytest.fixture(scope="module", params=KINDS.values(), ids=KINDS.keys())
def phantom(request) -> Phantom:
    camera, tissue = request.param
    return Phantom(PhantomParams(n_frames=N, width=80, height=64, seed=4, camera=camera, tissue=tissue))


@pytest.fixture(scope="module")
def views(phantom) -> list[View]:
    return [phantom.view(index) for index in range(N)]


@pytest.fixture(scope="module")
def still() -> Phantom:
    """Nothing moves, no tool, much noise."""
    params = PhantomParams(n_frames=N, width=160, height=128, seed=2, tissue="static", tools=0, noise=4.0)
    return Phantom(params)


def seen_depth(view: View) -> np.ndarray:
    assert view.frame.depth is not None
    return view.frame.depth


def interpolated(values: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """Bilinear values at pixel positions (N, 2) whose centres are at +0.5; NaN outside."""
    columns, rows = (pixels - 0.5).astype(np.float32).T[:, None]
    border = {"borderMode": cv2.BORDER_CONSTANT, "borderValue": (np.nan,) * 4}
    return cv2.remap(values.astype(np.float32), columns, rows, cv2.INTER_LINEAR, **border)[0]


def test_depth_is_where_the_surface_point_is(phantom, views):
    """Depth unprojected at the pixel centre is the point that the material coordinates name."""
    for index in (0, 5, 11):
        frame = views[index].frame
        points = frame.camera.unproject(seen_depth(views[index]))[frame.tissue_mask]
        material = views[index].material[frame.tissue_mask]
        wanted = phantom.surface.evaluate(material[:, 0], material[:, 1], frame.time)[0]
        np.testing.assert_allclose(points, wanted, atol=2e-5)  # Depth is float32: 4e-6 at 64 mm.


def test_a_tracked_tissue_point_is_seen_where_it_goes(phantom, views):
    """Random points of the tissue, moved and projected, meet their own material coordinates."""
    points = np.random.default_rng(0).uniform(-18, 18, (400, 2))
    for view in views[::3]:
        frame = view.frame
        position = phantom.surface.evaluate(points[:, 0], points[:, 1], frame.time)[0]
        pixels, depth = frame.camera.project(position)
        # Bilinear interpolation of a curved field at 0.8 mm a pixel.
        found = interpolated(view.material, pixels)
        on_tissue = interpolated(frame.tissue_mask, pixels) == 1
        assert on_tissue.sum() > 200
        assert np.abs(found - points)[on_tissue].max() < 0.05
        assert np.abs(interpolated(seen_depth(view), pixels) - depth)[on_tissue].max() < 0.05


def test_vessels_move_with_the_tissue():
    """A pixel well inside a vessel is on a vessel wherever its tissue point goes."""
    phantom = Phantom(PhantomParams(n_frames=N, seed=4, camera="moving"))
    first, later = phantom.view(0), phantom.view(N // 2)
    inside = cv2.erode(first.vessel_mask.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    material = first.material[inside]
    position = phantom.surface.evaluate(material[:, 0], material[:, 1], later.frame.time)[0]
    pixels, _ = later.frame.camera.project(position)
    on_tissue = interpolated(later.frame.tissue_mask, pixels) == 1
    met = interpolated(later.vessel_mask, pixels)[on_tissue] > 0
    assert on_tissue.sum() > 1000
    assert met.mean() > 0.98


def test_motion_is_several_millimetres_or_none(phantom, views):
    u, v = (axis.ravel() for axis in np.meshgrid(np.linspace(-20, 20, 21), np.linspace(-15, 15, 21)))
    track = np.stack([phantom.surface.evaluate(u, v, view.frame.time)[0] for view in views])
    farthest = np.linalg.norm(track - track[0], axis=2).max()
    if phantom.params.tissue == "static":
        assert farthest == 0
    else:
        assert 4 < farthest < 15
        assert np.linalg.norm(np.diff(track, axis=0), axis=2).max() < 4


def test_the_camera_moves_when_asked(phantom, views):
    cameras = [view.frame.camera for view in views]
    np.testing.assert_array_equal(cameras[0].camera_from_world, np.eye(4))
    distances = [np.linalg.norm(camera.position) for camera in cameras]
    if phantom.params.camera == "fixed":
        assert max(distances) == 0
    else:
        assert 5 < max(distances) < 20
    for camera in cameras:
        rotation = camera.camera_from_world[:3, :3]
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(rotation) == pytest.approx(1)


def test_tools_hide_depth_and_vessels(views):
    for view in views:
        tool = ~view.frame.tissue_mask
        assert 0.01 < tool.mean() < 0.4
        assert not seen_depth(view)[tool].any()
        assert (seen_depth(view)[~tool] > 30).all()
        assert not view.vessel_mask[tool].any()
        np.testing.assert_array_equal(view.frame.tissue_mask, view.frame.evaluation_mask)
    assert (views[0].frame.tissue_mask != views[N // 2].frame.tissue_mask).any()


def test_any_frame_can_be_drawn_in_any_order(phantom, views):
    again = phantom.view(7)
    np.testing.assert_array_equal(again.frame.image, views[7].frame.image)
    np.testing.assert_array_equal(seen_depth(again), seen_depth(views[7]))


def test_there_are_no_other_frames(phantom):
    for index in (-1, phantom.params.n_frames):
        with pytest.raises(IndexError, match="expected a frame from 0 to"):
            phantom.view(index)


def test_a_still_scene_differs_by_noise_alone(still):
    first, second = still.view(0), still.view(9)
    assert first.frame.tissue_mask.all()
    np.testing.assert_array_equal(seen_depth(first), seen_depth(second))
    np.testing.assert_array_equal(first.vessel_mask, second.vessel_mask)
    levels = [view.frame.image.astype(float) for view in (first, second)]
    lit = (levels[0] > 180) & (levels[0] < 240)
    # Noise of 4 at full brightness, rounding, and the difference of two draws.
    shot = 16 * (0.36 + 0.64 * levels[0][lit].mean() / 255)
    assert (levels[0] - levels[1])[lit].std() == pytest.approx(np.sqrt(2 * (shot + 1 / 12)), rel=0.05)


def test_the_picture_looks_like_endoscopy(still):
    view = still.view(0)
    image, vessel = view.frame.image.astype(float), view.vessel_mask
    assert image[..., 0].mean() > 1.2 * image[..., 2].mean()
    near = cv2.dilate(vessel.astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
    beside = near & ~vessel
    assert 0.08 < vessel.mean() < 0.4
    assert image[vessel][:, 1].mean() < 0.92 * image[beside][:, 1].mean()
    corners = np.mean([image[:12, :12].mean(), image[:12, -12:].mean(), image[-12:, -12:].mean()])
    assert corners < 0.75 * image[44:84, 60:100].mean()
    assert 1e-4 < (image.min(axis=2) > 200).mean() < 0.05  # Highlights.


@pytest.mark.parametrize("seed", range(12))
def test_every_ray_meets_the_surface_once(seed):
    """The projection of the tissue never folds over: its Jacobian keeps its sign, at any time."""
    surface = grow_surface(np.random.default_rng(seed), moving=True, cycles=1)
    u, v = (axis.ravel() for axis in np.meshgrid(np.linspace(-50, 50, 60), np.linspace(-45, 45, 50)))
    camera = Camera(285, 285, 160, 128, 320, 256)
    for time in np.linspace(0, 1, 7):
        position, along_u, along_v = surface.evaluate(u, v, time)
        pixels, depth = camera.project(position)
        seen = (np.abs(pixels - [160, 128]) < [175, 143]).all(axis=1)
        facing = (np.cross(along_v, along_u) * position).sum(axis=1)
        assert (facing[seen] < 0).all()
        assert 30 < depth[seen].min() < depth[seen].max() < 100


def test_derivatives_of_the_surface():
    surface = grow_surface(np.random.default_rng(1), moving=True, cycles=2)
    u, v = np.random.default_rng(2).uniform(-30, 30, (2, 50))
    _, along_u, along_v = surface.evaluate(u, v, 0.3)
    step = 1e-5
    forward = [surface.evaluate(u + a, v + b, 0.3)[0] for a, b in ((step, 0), (0, step))]
    backward = [surface.evaluate(u - a, v - b, 0.3)[0] for a, b in ((step, 0), (0, step))]
    for exact, ahead, behind in zip((along_u, along_v), forward, backward, strict=True):
        np.testing.assert_allclose(exact, (ahead - behind) / (2 * step), atol=1e-8)


def distance_to_segment(points: np.ndarray, capsule: Capsule) -> np.ndarray:
    axis = capsule.end - capsule.start
    share = np.clip((points - capsule.start) @ axis / (axis @ axis), 0, 1)
    return np.linalg.norm(points - capsule.start - share[:, None] * axis, axis=1)


def test_rays_meet_capsules_first_where_they_touch():
    rng = np.random.default_rng(8)
    capsules = [Capsule(*rng.uniform([-20, -20, 30], [20, 20, 60], (2, 3)), 3.0, 0.5) for _ in range(3)]  # type: ignore[call-arg]
    directions = rng.normal([0, 0, 2], 0.7, (800, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    hits = hit_tools(np.zeros(3), directions, capsules)
    met = np.isfinite(hits.distance)
    assert 50 < met.sum() < 750
    steps = np.linspace(0, 100, 1501)
    for ray, reach, normal in zip(directions, hits.distance, hits.normal, strict=True):
        gap = np.min([distance_to_segment(steps[:, None] * ray, capsule) for capsule in capsules], axis=0) - 3
        outside = steps < reach
        assert (gap[outside] > -1e-9).all()
        if np.isfinite(reach):
            probe = reach * ray + 0.5 * normal
            off = min(distance_to_segment(probe[None], capsule)[0] for capsule in capsules)
            assert off <= 3.5 + 1e-9
            nearest = min(distance_to_segment((reach * ray)[None], capsule)[0] for capsule in capsules)
            assert nearest == pytest.approx(3, abs=1e-9)


def test_vessels_branch_by_murrays_law():
    vessels = grow_vessels(np.random.default_rng(0), 60.0)
    radii = np.array([vessel.radius for vessel in vessels])
    assert radii.max() > 4 * radii.min()
    daughters = defaultdict(list)
    for vessel in vessels:
        daughters[tuple(vessel.path[0])].append(vessel)
    forks = [(vessel, daughters[tuple(vessel.path[-1])]) for vessel in vessels]
    pairs = [(mother, born) for mother, born in forks if len(born) == 2]
    assert len(pairs) > 50
    for mother, born in pairs:
        cubes = sum((vessel.radius / 0.97) ** 3 for vessel in born)  # They taper by 3 % a stretch.
        assert cubes == pytest.approx(mother.radius**3)
        assert {vessel.vein for vessel in born} == {mother.vein}


def files_of(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_equal_parameters_write_equal_bytes(tmp_path, monkeypatch):
    monkeypatch.setattr("renderer.phantom.paint_tissue", paint_tissue)  # Each for itself.
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        write_phantom(tmp_path / name, PhantomParams(**SMALL, seed=seed))
    first, again, other = (files_of(tmp_path / name) for name in "abc")
    assert first == again
    assert first.keys() == other.keys()
    image = "images/frame-000001.color.png"
    assert first[image] != other[image]
    assert not list(tmp_path.glob("*.partial"))


def test_what_is_written_opens_as_it_was_drawn(tmp_path):
    params = PhantomParams(**SMALL, seed=1, camera="moving")
    write_phantom(tmp_path / "clip", params)
    clip = open_clip(tmp_path / "clip")
    view = Phantom(params).view(1)
    frame = clip.read_frame(1)
    assert (len(clip), clip.size, clip.format) == (2, (48, 32), "endonerf")
    np.testing.assert_array_equal(frame.image, view.frame.image)
    np.testing.assert_array_equal(frame.tissue_mask, view.frame.tissue_mask)
    assert frame.depth is not None
    assert np.abs(frame.depth - seen_depth(view)).max() <= 1 / 64
    np.testing.assert_allclose(
        frame.camera.camera_from_world, view.frame.camera.camera_from_world, atol=1e-12
    )
    with Image.open(tmp_path / "clip/vessel_masks/frame-000001.vessels.png") as vessels:
        np.testing.assert_array_equal(np.asarray(vessels), view.vessel_mask)


def test_the_scared_layout_gives_back_the_points(tmp_path):
    params = PhantomParams(**SMALL, seed=1, camera="moving", tissue="static", tools=1)
    write_phantom(tmp_path / "keyframe", params, "scared")
    data = tmp_path / "keyframe/data"
    view = Phantom(params).view(1)
    q = np.array(
        json.loads((data / "reprojection_data/frame_data000001.json").read_text())["reprojection-matrix"]
    )
    poses = json.loads((data / "frame_data/frame_data000001.json").read_text())
    with Image.open(data / "disparity/frame_data000001.tiff") as stored:
        disparity = np.asarray(stored)
    measured = disparity > 0
    np.testing.assert_array_equal(measured, seen_depth(view) > 0)
    local = cv2.reprojectImageTo3D(disparity, q.astype(np.float32))[measured]
    world = (local - np.array(poses["camera-pose"])[:3, 3]) @ np.array(poses["camera-pose"])[:3, :3]
    wanted = view.frame.camera.unproject(seen_depth(view))[measured]
    np.testing.assert_allclose(world, wanted, atol=2e-3)
    assert poses["camera-calibration"]["KL"][0][2] == 48 / 2 - 0.5
    assert poses["camera-calibration"]["T"][0][0] == -BASELINE
    assert (tmp_path / "keyframe/point_cloud.obj").read_text().startswith("v ")
    with Image.open(data / "left_finalpass/frame_data000001.png") as left:
        np.testing.assert_array_equal(np.asarray(left), view.frame.image)


def test_nothing_is_overwritten(tmp_path):
    (tmp_path / "clip").mkdir()
    with pytest.raises(ClipError, match=r"exists: .*clip"):
        write_phantom(tmp_path / "clip", PhantomParams(**SMALL))
    (tmp_path / "file").write_text("x")
    with pytest.raises(ClipError, match="cannot write"):
        write_phantom(tmp_path / "file/clip", PhantomParams(**SMALL))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["clip", "file"]


def test_what_lies_beside_is_left_alone(tmp_path):
    own = tmp_path / "clip.partial" / "vessel_masks"
    own.mkdir(parents=True)
    (own / "mine.txt").write_text("mine")
    write_phantom(tmp_path / "clip", PhantomParams(**SMALL))
    assert (own / "mine.txt").read_text() == "mine"
    assert not (tmp_path / "clip" / "vessel_masks" / "mine.txt").exists()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["clip", "clip.partial"]


def test_an_interruption_leaves_nothing(tmp_path, monkeypatch):
    def stop(self, index):
        raise KeyboardInterrupt

    monkeypatch.setattr(Phantom, "view", stop)
    with pytest.raises(KeyboardInterrupt):
        write_phantom(tmp_path / "clip", PhantomParams(**SMALL))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "wrong", [{"n_frames": 0}, {"width": 5}, {"seed": -1}, {"camera": "shaky"}, {"tools": 3}, {"size": 3}]
)
def test_parameters_out_of_range_are_refused(wrong):
    with pytest.raises(ValidationError):
        PhantomParams(**wrong)


def test_tall_and_tiny_pictures_can_be_drawn():
    view = Phantom(PhantomParams(n_frames=1, width=16, height=64, seed=0)).view(0)
    assert view.frame.image.shape == (64, 16, 3)
    assert (seen_depth(view)[view.frame.tissue_mask] > 0).all()


def test_the_embedded_clip_is_what_its_docstring_says():
    """Geometry to the steps of its files; colours but for rounding on other machines."""
    clip = open_clip(phantom_path())
    view = Phantom(PhantomParams(seed=3, noise=0.3)).view(5)
    frame = clip.read_frame(5)
    assert frame.depth is not None
    assert np.abs(frame.depth - seen_depth(view))[frame.tissue_mask & view.frame.tissue_mask].max() < 0.02
    assert (frame.tissue_mask == view.frame.tissue_mask).mean() > 0.999
    everything = np.ones(frame.tissue_mask.shape, dtype=bool)
    assert psnr(view.frame.image / 255, frame.image / 255, everything) > 40


def test_brightness_that_pumps_is_told_and_nothing_else_differs() -> None:
    steady = Phantom(PhantomParams(n_frames=6, width=48, height=32, noise=0.0))
    pumping = Phantom(PhantomParams(n_frames=6, width=48, height=32, noise=0.0, pumping=0.2))
    assert [steady.gain(index) for index in range(6)] == [1.0] * 6
    gains = [pumping.gain(index) for index in range(6)]
    assert len(set(gains)) == 6
    assert all(0.8 <= gain <= 1.2 for gain in gains)
    for index in (0, 3):
        one, other = steady.view(index).frame, pumping.view(index).frame
        seen = (one.image < 255) & (other.image < 255)
        assert seen.mean() > 0.9
        assert np.abs(other.image - gains[index] * one.image)[seen].max() <= 1.2
        assert np.array_equal(one.depth, other.depth)
