"""SCARED keyframes: what is written comes back, and Q, the poses and the depth are read as they are meant."""

from __future__ import annotations

import json
import shutil
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from renderer.camera import Camera
from renderer.phantom import Phantom, PhantomParams, write_phantom
from renderer.readers.clip_options import ClipOptions
from renderer.readers.data_sets.scared import BASELINE, NEAREST, usual_step, write_scared
from renderer.sources import open_clip
from tests.renderer.small_clip import COUNT, HEIGHT, LENS, WIDTH, points_of, read_all, refusal, small_frames


@pytest.fixture
def keyframe(tmp_path: Path) -> Path:
    path = tmp_path / "keyframe_1"
    write_scared(path, small_frames(angle=0.02))
    return path


def edit(folder: Path, name: str, change: Callable[[np.ndarray], np.ndarray]) -> None:
    """Rewrites the matrix `name` in every JSON file of a folder."""
    for path in folder.iterdir():
        values = json.loads(path.read_text())
        values[name] = change(np.array(values[name])).tolist()
        path.write_text(json.dumps(values))


def write_disparity(keyframe: Path, index: int, disparity: np.ndarray) -> None:
    path = keyframe / f"data/disparity/frame_data{index:06d}.tiff"
    Image.fromarray(disparity.astype(np.float32)).save(path)


def write_points(path: Path, points: np.ndarray) -> None:
    """A TIFF of three float channels in the order given, by the letter of TIFF 6.0."""
    height, width, channels = points.shape
    data = points.astype("<f4").tobytes()
    short, long = 3, 4
    after = 8 + 2 + 12 * 11 + 4
    tags = [
        (256, long, 1, width), (257, long, 1, height), (258, short, channels, after),
        (259, short, 1, 1), (262, short, 1, 2), (273, long, 1, after + 12), (277, short, 1, channels),
        (278, long, 1, height), (279, long, 1, len(data)), (284, short, 1, 1),
        (339, short, channels, after + 6),
    ]  # fmt: skip
    entries = b"".join(struct.pack("<HHII", *tag) for tag in tags)
    head = b"II*\0" + struct.pack("<IH", 8, len(tags)) + entries + struct.pack("<I", 0)
    path.write_bytes(head + struct.pack("<6H", 32, 32, 32, 3, 3, 3) + data)


def use_points(keyframe: Path) -> None:
    """Puts scene_points/ of both eyes in the place of disparity/; those of the right eye are far off."""
    data = keyframe / "data"
    shutil.rmtree(data / "disparity")
    (data / "scene_points").mkdir()
    for frame in small_frames(angle=0.02):
        left = LENS.unproject(frame.depth)
        both = np.concatenate([left, np.full_like(left, 44.0)])
        write_points(data / f"scene_points/scene_points{frame.index:06d}.tiff", both)


def test_the_phantom_comes_back(tmp_path):
    params = PhantomParams(n_frames=3, width=64, height=48, seed=2, camera="moving", tissue="static", tools=1)
    write_phantom(tmp_path / "keyframe", params, "scared")
    clip = open_clip(tmp_path / "keyframe")
    assert (len(clip), clip.size, clip.format, clip.unit) == (3, (64, 48), "scared", "mm")
    assert (clip.has_depth, clip.baseline, clip.notices) == (True, pytest.approx(BASELINE), ())
    for index in range(3):
        frame, truth = clip.read_frame(index), Phantom(params).view(index).frame
        np.testing.assert_array_equal(frame.image, truth.image)
        np.testing.assert_array_equal(frame.depth > 0, truth.depth > 0)
        np.testing.assert_allclose(points_of(frame), points_of(truth), atol=1e-3)
        np.testing.assert_array_equal(frame.tissue_mask, truth.tissue_mask)
        assert (frame.index, frame.time) == (index, index / 3)
    assert not clip.camera_is_fixed


def test_the_folder_may_be_the_keyframe_or_its_data(keyframe):
    whole, data = open_clip(keyframe), open_clip(keyframe / "data")
    assert whole.cameras == data.cameras
    assert whole.name == data.name == "keyframe_1"


def test_intrinsics_are_those_of_q(keyframe):
    for path in (keyframe / "data/frame_data").iterdir():
        values = json.loads(path.read_text())
        values["camera-calibration"]["KL"] = [[1.0, 0, 2], [0, 3, 4], [0, 0, 1]]
        path.write_text(json.dumps(values))
    camera = open_clip(keyframe).cameras[0]
    numbers = (camera.fx, camera.fy, camera.cx, camera.cy)
    assert numbers == pytest.approx((LENS.fx, LENS.fy, LENS.cx, LENS.cy))


@pytest.mark.parametrize("sign", [1, -1])
def test_the_baseline_has_no_sign(keyframe, sign):
    edit(keyframe / "data/reprojection_data", "reprojection-matrix", lambda q: q * [[1], [1], [1], [sign]])
    truth = small_frames(angle=0.02)[4]
    np.testing.assert_allclose(open_clip(keyframe).read_frame(4).depth, truth.depth, rtol=1e-5)


def test_eyes_whose_principal_points_differ_give_the_depth_that_q_says(keyframe):
    plain, apart = open_clip(keyframe).read_frame(4).depth, 3.0

    def moved(q):
        q[3, 3] = apart * q[3, 2]
        return q

    edit(keyframe / "data/reprojection_data", "reprojection-matrix", moved)
    focal_by_baseline = LENS.fx * open_clip(keyframe).baseline
    expected = focal_by_baseline / (focal_by_baseline / np.where(plain > 0, plain, np.inf) + apart)
    known = (plain > 0) & (expected > NEAREST)
    assert known.mean() > 0.5
    np.testing.assert_allclose(open_clip(keyframe).read_frame(4).depth[known], expected[known], rtol=1e-4)


def test_the_first_camera_is_the_world(keyframe):
    plain = open_clip(keyframe)
    world = np.eye(4)
    world[:3, :3] = [[0, -1, 0], [0, 0, -1], [1, 0, 0]]
    world[:3, 3] = 5, -60, 300
    edit(keyframe / "data/frame_data", "camera-pose", lambda pose: pose @ world)
    clip = open_clip(keyframe)
    np.testing.assert_array_equal(clip.cameras[0].camera_from_world.round(12), np.eye(4))
    for one, other in zip(clip.cameras, plain.cameras, strict=True):
        np.testing.assert_allclose(one.camera_from_world, other.camera_from_world, atol=1e-9)


def test_depth_out_of_range_is_no_measurement(keyframe):
    wanted = np.zeros((HEIGHT, WIDTH), dtype=np.float32)
    wanted[0, :8] = 29.5, 30.5, 299, 301, 80, 80, 80, 80
    disparity = np.where(wanted > 0, LENS.fx * BASELINE / np.where(wanted > 0, wanted, 1), 0)
    disparity[0, 4:7] = np.nan, -1, np.inf
    write_disparity(keyframe, 0, disparity)
    depth = open_clip(keyframe).read_frame(0).depth
    np.testing.assert_allclose(depth[0, :8], [0, 30.5, 299, 0, 0, 0, 0, 80], rtol=1e-5)
    assert not depth[1:].any()


def test_small_holes_are_tissue_without_depth(tmp_path):
    lens = Camera(500.0, 500.0, 250.0, 30.0, 512, 64)  # Closed by a square of 4 pixels.
    frame = small_frames(lens, count=1)[0]
    depth = np.zeros((64, 512), dtype=np.float32)
    depth[8:40, 100:300] = 60
    depth[20:23, 150:153] = 0
    depth[20:28, 200:208] = 0
    write_scared(tmp_path / "k", [replace(frame, depth=depth)])
    read = open_clip(tmp_path / "k").read_frame(0)
    wanted = depth > 0
    wanted[20:23, 150:153] = True
    np.testing.assert_array_equal(read.tissue_mask, wanted)
    np.testing.assert_array_equal(read.evaluation_mask, wanted)
    np.testing.assert_array_equal(read.depth > 0, depth > 0)


@pytest.mark.parametrize(
    ("folder", "step"),
    [("dataset_1", 2), ("dataset_2", 1), ("dataset_3", 4), ("dataset_7", 8), ("dataset_10", 1),
     ("my_dataset_1", 1), ("dataset_1b", 1)],
)  # fmt: skip
def test_frames_are_skipped_as_the_field_does(tmp_path, folder, step):
    path = tmp_path / folder / "keyframe_1"
    write_scared(path, small_frames(angle=0.02))
    assert usual_step(path) == usual_step(path / "data") == step
    clip = open_clip(path)
    kept = range(0, COUNT, step)
    assert clip.labels == tuple(f"frame_data{index:06d}.png" for index in kept)
    assert ("--frame-step" in "".join(clip.notices)) == (step > 1)
    truth = small_frames(angle=0.02)
    for index, source in enumerate(kept):
        frame = clip.read_frame(index)
        assert (frame.index, frame.time) == (index, index / len(kept))
        np.testing.assert_allclose(points_of(frame), points_of(truth[source]), atol=1e-3)
        np.testing.assert_array_equal(clip.read_image(index), truth[source].image)
    assert len(open_clip(path, ClipOptions(frame_step=3))) == 4


def test_the_name_says_the_dataset(tmp_path):
    write_scared(tmp_path / "dataset_2/keyframe_1", small_frames(count=1))
    assert open_clip(tmp_path / "dataset_2/keyframe_1").name == "dataset_2-keyframe_1"


def test_points_give_depth_where_there_is_no_disparity(keyframe):
    use_points(keyframe)
    clip = open_clip(keyframe)
    assert clip.has_depth
    assert "scene_points" in "".join(clip.notices)
    for frame, truth in zip(read_all(keyframe), small_frames(angle=0.02), strict=True):
        np.testing.assert_array_equal(frame.depth > 0, truth.depth > 0)
        np.testing.assert_allclose(points_of(frame), points_of(truth), atol=1e-3)


def test_the_nearest_of_several_points_is_seen(keyframe):
    use_points(keyframe)
    points = np.full((HEIGHT, WIDTH, 3), np.nan)
    ray = np.array([(10.5 - LENS.cx) / LENS.fx, (20.2 - LENS.cy) / LENS.fy, 1])
    points[0, :4] = 90 * ray, 60 * ray, 70 * ray, -60 * ray
    points[1] = [0, 900, 50]  # Out of the picture.
    write_points(keyframe / "data/scene_points/scene_points000000.tiff", points)
    depth = open_clip(keyframe).read_frame(0).depth
    assert depth[20, 10] == 60
    assert (depth > 0).sum() == 1


def test_without_depth_every_pixel_is_tissue(keyframe):
    shutil.rmtree(keyframe / "data/disparity")
    clip = open_clip(keyframe)
    assert not clip.has_depth
    assert clip.baseline == pytest.approx(BASELINE)
    assert "no measured depth" in "".join(clip.notices)
    assert clip.read_frame(0).tissue_mask.all()


def test_strays_are_reported_and_not_paired(keyframe):
    (keyframe / "data/left_finalpass/Thumbs.db").write_text("x")
    shutil.copy(
        keyframe / "data/disparity/frame_data000001.tiff", keyframe / "data/disparity/frame_data000099.tiff"
    )
    clip = open_clip(keyframe)
    assert len(clip) == COUNT
    assert ["Thumbs.db" in clip.notices[0], "frame_data000099" in clip.notices[1]] == [True, True]


def test_what_does_not_agree_is_refused(keyframe, tmp_path):
    data = keyframe / "data"
    broken: dict[str, Callable[[Path], object]] = {
        "left_finalpass": lambda data: shutil.rmtree(data / "left_finalpass"),
        "number 3": lambda data: (data / "frame_data/frame_data000003.json").unlink(),
        "reprojection-matrix": lambda data: (data / "reprojection_data/frame_data000002.json").write_text(
            "{"
        ),
        "4x4": lambda data: edit(data / "frame_data", "camera-pose", lambda pose: pose[:3]),
        "rotation": lambda data: edit(data / "frame_data", "camera-pose", lambda pose: 2 * pose),
        "baseline": lambda data: edit(data / "reprojection_data", "reprojection-matrix", lambda q: 0 * q),
        "number 9": lambda data: (data / "disparity/frame_data000009.tiff").unlink(),
        "64x48": lambda data: write_disparity(data.parent, 5, np.zeros((24, 32))),
    }
    for number, (said, damage) in enumerate(broken.items()):
        copy = tmp_path / f"copy{number}"
        shutil.copytree(data, copy / "data")
        damage(copy / "data")
        assert said in refusal(copy)


def test_points_of_another_shape_are_refused(keyframe):
    use_points(keyframe)
    path = keyframe / "data/scene_points/scene_points000004.tiff"
    write_points(path, np.zeros((HEIGHT + 1, WIDTH, 3)))
    assert f"({2 * HEIGHT}, width, 3)" in refusal(keyframe)
    path.write_bytes(b"II*\0 no more of it")
    assert path.name in refusal(keyframe)
