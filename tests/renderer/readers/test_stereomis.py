"""StereoMIS: preprocessed sequences and those that Deform3DGS converts, told apart by what they hold."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from renderer.camera import Camera
from renderer.clip import ClipError
from renderer.readers.clip_options import ClipOptions
from renderer.readers.data_sets.converted_stereomis import is_converted_stereomis
from renderer.readers.lenses.rectification import read_rectified
from renderer.sources import open_clip
from tests.renderer.readers.test_rectification import calibration
from tests.renderer.small_clip import COUNT, points_of, read_all, refusal, small_frames

FIRST = 9100
"""Number of the first frame of a sequence."""
SMALL = Camera(60.0, 60.0, 33.3, 22.7, 80, 64)
"""Pictures of the shape of the calibration's."""


@pytest.fixture
def sequence(tmp_path: Path) -> Path:
    return write_sequence(tmp_path / "P3")


def write_sequence(path: Path) -> Path:
    """Frames from FIRST on, both eyes, masks of tissue at half size, and a trajectory in metres."""
    for name in ("video_frames", "masks"):
        (path / name).mkdir(parents=True)
    rows = []
    for frame in small_frames(SMALL, 0.02):
        number = FIRST + frame.index
        for eye in "lr":
            Image.fromarray(frame.image).save(path / f"video_frames/{number:06d}{eye}.png")
        Image.fromarray(frame.tissue_mask.astype(np.uint8)).save(path / f"masks/{number:06d}l.png")
        angle = 0.02 * frame.index  # Camera from world turns the y axis by it, world from camera back.
        quaternion = 0, np.sin(-angle / 2), 0, np.cos(-angle / 2)
        rows.append([number, *(frame.camera.position / 1000), *quaternion])
    np.savetxt(path / "groundtruth.txt", [[0, 9, 9, 9, 0, 0, 0, 1], *rows])
    (path / "StereoCalibration.ini").write_text(calibration())
    return path


@pytest.fixture
def converted(tmp_path: Path) -> Path:
    return write_converted(tmp_path / "plain_name")


def write_converted(path: Path) -> Path:
    for name in ("images", "masks", "depth"):
        (path / name).mkdir(parents=True)
    for frame in small_frames(SMALL):
        name = f"frame-{frame.index:06d}"
        Image.fromarray(frame.image).save(path / f"images/{name}.color.png")
        tissue = np.where(frame.tissue_mask, 255, 0).astype(np.uint8)
        Image.fromarray(tissue).save(path / f"masks/{name}.mask.png")
        Image.fromarray(np.rint(frame.depth).astype(np.uint8)).save(path / f"depth/{name}.depth.png")
    say(path, SMALL.cy, SMALL.cx)
    return path


def say(path: Path, one: float, two: float, poses: np.ndarray | None = None) -> None:
    """Writes poses_bounds.npy with these numbers where EndoNeRF has height and width."""
    matrices = np.tile(np.eye(3, 4), (COUNT, 1, 1)) if poses is None else poses
    last = np.tile([[[one], [two], [SMALL.fx]]], (COUNT, 1, 1))
    rows = np.concatenate([matrices, last], axis=2).reshape(COUNT, 15)
    np.save(path / "poses_bounds.npy", np.column_stack([rows, np.full(COUNT, 0.03), np.full(COUNT, 250.0)]))


def test_a_sequence_opens_with_its_left_pictures(sequence):
    clip = open_clip(sequence)
    assert (len(clip), clip.size, clip.format, clip.unit) == (COUNT, (80, 64), "stereomis", "mm")
    assert clip.labels[0] == f"{FIRST:06d}l.png"
    assert not clip.has_depth
    rectified = read_rectified(sequence / "StereoCalibration.ini", (80, 64))
    assert clip.baseline == rectified.baseline == pytest.approx(4.1, rel=1e-3)
    truth = small_frames(SMALL, 0.02)
    for frame, wanted in zip(read_all(sequence), truth, strict=True):
        np.testing.assert_array_equal(frame.image, wanted.image)
        np.testing.assert_array_equal(frame.tissue_mask, wanted.tissue_mask)
        assert (frame.camera.fx, frame.camera.cx) == (rectified.camera.fx, rectified.camera.cx)
        np.testing.assert_allclose(frame.camera.camera_from_world, wanted.camera.camera_from_world, atol=1e-9)


def test_pictures_may_lie_in_the_folder_itself(sequence):
    for path in (sequence / "video_frames").iterdir():
        path.rename(sequence / path.name)
    (sequence / "video_frames").rmdir()
    assert len(open_clip(sequence)) == COUNT


def test_frames_without_a_mask_are_left_out_and_said(sequence):
    (sequence / f"masks/{FIRST + 2:06d}l.png").unlink()
    clip = open_clip(sequence)
    assert len(clip) == COUNT - 1
    assert clip.labels[2] == f"{FIRST + 3:06d}l.png"
    assert "1 of 10" in "".join(clip.notices)
    np.testing.assert_array_equal(clip.read_frame(2).image, small_frames(SMALL)[3].image)


def test_masks_of_half_the_size_fit(sequence):
    for path in (sequence / "masks").iterdir():
        Image.fromarray(np.asarray(Image.open(path))[::2, ::2]).save(path)
    for frame, wanted in zip(read_all(sequence), small_frames(SMALL), strict=True):
        np.testing.assert_array_equal(frame.tissue_mask[::2, ::2], wanted.tissue_mask[::2, ::2])


def test_lossy_masks_that_mark_nothing_for_being_dark_are_named(sequence):
    for path in list((sequence / "masks").iterdir()):
        tissue = np.where(np.asarray(Image.open(path)), 90, 0).astype(np.uint8)
        path.unlink()
        Image.fromarray(tissue).save(path.with_suffix(".jpg"))
    assert any("masks/ holds" in told and "marks nothing" in told for told in open_clip(sequence).notices)


def test_a_mask_of_another_shape_is_refused_when_the_clip_is_opened(sequence):
    last = sorted((sequence / "masks").iterdir())[-1]
    Image.new("L", (9, 9)).save(last)
    with pytest.raises(ClipError, match=last.name):
        open_clip(sequence)


def test_without_masks_and_trajectory_the_camera_stands_still(sequence):
    shutil.rmtree(sequence / "masks")
    (sequence / "groundtruth.txt").unlink()
    clip = open_clip(sequence, ClipOptions(depth="off"))
    assert clip.camera_is_fixed
    assert clip.read_frame(0).tissue_mask.all()
    assert len(clip.notices) == 2


def test_masks_of_tools_are_refused_unless_they_are_meant(sequence):
    for path in (sequence / "masks").iterdir():
        Image.fromarray(1 - np.asarray(Image.open(path))).save(path)
    assert "--mask-polarity tool" in refusal(sequence)
    meant = open_clip(sequence, ClipOptions(mask_polarity="tool")).read_frame(0)
    np.testing.assert_array_equal(meant.tissue_mask, small_frames(SMALL)[0].tissue_mask)


def test_what_does_not_agree_is_refused(sequence, tmp_path):
    broken: dict[str, Callable[[Path], object]] = {
        "NNNNNNl.png": lambda path: [file.unlink() for file in (path / "video_frames").glob("*l.png")],
        "none for number 9100": lambda path: np.savetxt(path / "groundtruth.txt", np.ones((3, 8))),
        "qx qy qz qw": lambda path: (path / "groundtruth.txt").write_text("9100 1 2 3\n"),
        "other than 0": lambda path: np.savetxt(
            path / "groundtruth.txt", [[FIRST + index, *[0.0] * 7] for index in range(COUNT)]
        ),
        "mask of the shape": lambda path: Image.new("L", (30, 60)).save(path / f"masks/{FIRST:06d}l.png"),
        "a mask numbered as an image": lambda path: [
            file.rename(file.with_name(f"1{file.name}")) for file in list((path / "masks").iterdir())
        ],
    }
    for number, (said, damage) in enumerate(broken.items()):
        copy = tmp_path / f"copy{number}"
        shutil.copytree(sequence, copy)
        damage(copy)
        assert said in refusal(copy)


def test_a_converted_clip_is_known_by_what_it_holds(converted):
    assert is_converted_stereomis(converted)
    clip = open_clip(converted)
    assert (len(clip), clip.format, clip.unit, clip.camera_is_fixed) == (COUNT, "stereomis", "mm", True)
    camera = clip.cameras[0]
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (SMALL.fx, SMALL.fy, SMALL.cx, SMALL.cy)
    assert sum("principal point" in said for said in clip.notices) == 1
    for frame, wanted in zip(read_all(converted), small_frames(SMALL), strict=True):
        np.testing.assert_array_equal(frame.tissue_mask, wanted.tissue_mask)
        np.testing.assert_array_equal(frame.depth, np.rint(wanted.depth))
        assert frame.camera == camera
        truth = SMALL.unproject(np.rint(wanted.depth))[wanted.depth > 0]
        np.testing.assert_allclose(points_of(frame), truth, atol=1e-9)


def test_a_converted_clip_has_the_focal_length_of_each_row(converted):
    rows = np.load(converted / "poses_bounds.npy")
    rows[2:, 14] *= 2
    np.save(converted / "poses_bounds.npy", rows)
    focals = [camera.fx for camera in open_clip(converted).cameras]
    assert focals == [SMALL.fx] * 2 + [2 * SMALL.fx] * (COUNT - 2)


def test_poses_of_a_converted_clip_that_are_not_quite_rotations_are_told(converted):
    poses = np.tile(1.001 * np.eye(3, 4), (COUNT, 1, 1))
    say(converted, SMALL.cy, SMALL.cx, poses)
    assert any("not quite rotations" in notice for notice in open_clip(converted).notices)


def test_a_principal_point_in_the_middle_is_no_size_when_masks_mark_tissue(converted):
    say(converted, 32.0, 40.0)
    camera = open_clip(converted).cameras[0]
    assert (camera.fx, camera.cx, camera.cy) == (SMALL.fx, 40.0, 32.0)


def test_a_smaller_size_is_no_principal_point_when_masks_mark_tools(converted):
    for path in (converted / "masks").iterdir():
        Image.fromarray(255 - np.asarray(Image.open(path))).save(path)
    say(converted, 32.0, 40.0)
    assert not is_converted_stereomis(converted)
    clip = open_clip(converted)
    assert (clip.format, clip.cameras[0].fx) == ("endonerf", 2 * SMALL.fx)


def test_masks_that_clearly_mark_tools_are_read_as_such(converted):
    for path in (converted / "masks").iterdir():
        Image.fromarray(255 - np.asarray(Image.open(path))).save(path)
    frame = open_clip(converted).read_frame(3)
    np.testing.assert_array_equal(frame.tissue_mask, small_frames(SMALL)[3].tissue_mask)


def test_polarity_that_is_said_is_followed(converted):
    frame = open_clip(converted, ClipOptions(mask_polarity="tool")).read_frame(3)
    np.testing.assert_array_equal(frame.tissue_mask, ~small_frames(SMALL)[3].tissue_mask)


def test_the_size_of_the_pictures_makes_it_an_endonerf_clip(converted):
    say(converted, SMALL.height, SMALL.width)
    assert not is_converted_stereomis(converted)
    assert "masks" in refusal(converted)  # They are inverted, then.


def test_depth_beyond_the_range_is_no_measurement(converted):
    path = converted / "depth/frame-000000.depth.png"
    depth = np.full((64, 80), 240, dtype=np.uint8)
    depth[0, 0] = 251
    Image.fromarray(depth).save(path)
    frame = open_clip(converted).read_frame(0)
    assert frame.depth[0, 0] == 0
    assert (frame.depth > 0).sum() == frame.tissue_mask.sum() - 1
