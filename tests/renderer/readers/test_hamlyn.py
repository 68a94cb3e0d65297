"""Hamlyn clips: the left columns go, intrinsics and masks are honoured, odd frames can be held out."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from renderer.camera import Camera
from renderer.readers.clip_options import ClipOptions
from renderer.readers.data_sets.hamlyn import LEFT_COLUMNS
from renderer.sources import open_clip
from tests.renderer.small_clip import COUNT, points_of, read_all, refusal, small_frames

WHOLE = Camera(80.0, 84.0, 61.5, 20.5, 104, 48)
"""Of the pictures before they are cut."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_hamlyn(tmp_path / "rectified01")


def write_hamlyn(path: Path) -> Path:
    for name in ("images", "gt_masks", "gt_depth"):
        (path / name).mkdir(parents=True)
    for frame in small_frames(WHOLE):
        name = f"{frame.index:06d}.png"
        Image.fromarray(frame.image).save(path / "images" / name)
        Image.fromarray(np.where(frame.tissue_mask, 0, 3).astype(np.uint8)).save(path / "gt_masks" / name)
        Image.fromarray(np.rint(frame.depth).astype(np.uint16)).save(path / "gt_depth" / name)
    k = WHOLE.intrinsics - [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]]
    np.savetxt(path / "intrinsics.txt", k)
    return path


def test_the_left_columns_are_cut_and_the_camera_moves_with_them(folder):
    clip = open_clip(folder)
    assert (len(clip), clip.format, clip.unit, clip.notices) == (COUNT, "hamlyn", "mm", ())
    assert clip.size == (WHOLE.width - LEFT_COLUMNS, WHOLE.height)
    camera = clip.cameras[0]
    moved = (camera.fx, camera.fy, camera.cx + LEFT_COLUMNS, camera.cy)
    assert moved == pytest.approx((WHOLE.fx, WHOLE.fy, WHOLE.cx, WHOLE.cy))
    assert clip.camera_is_fixed
    for frame, truth in zip(read_all(folder), small_frames(WHOLE), strict=True):
        np.testing.assert_array_equal(frame.image, truth.image[:, LEFT_COLUMNS:])
        np.testing.assert_array_equal(clip.read_image(frame.index), frame.image)
        np.testing.assert_array_equal(frame.tissue_mask, truth.tissue_mask[:, LEFT_COLUMNS:])
        np.testing.assert_array_equal(frame.evaluation_mask, frame.tissue_mask)
        depth = np.rint(truth.depth)
        np.testing.assert_array_equal(frame.depth, depth[:, LEFT_COLUMNS:])
        kept = WHOLE.unproject(depth)[:, LEFT_COLUMNS:]
        np.testing.assert_allclose(points_of(frame), kept[frame.depth > 0], atol=1e-9)


def test_failed_matches_are_no_measurement(folder):
    path = folder / "gt_depth/000002.png"
    depth = np.asarray(Image.open(path)).copy()
    depth[0, 50:52] = 1500, 5
    Image.fromarray(depth).save(path)
    read = open_clip(folder).read_frame(2).depth
    assert not read[0, 50 - LEFT_COLUMNS : 52 - LEFT_COLUMNS].any()
    assert (read > 0).sum() == (depth[:, LEFT_COLUMNS:] > 0).sum() - 2


def test_strays_are_reported_and_not_paired(folder):
    shutil.copy(folder / "gt_masks/000001.png", folder / "gt_masks/000077.png")
    clip = open_clip(folder)
    assert len(clip) == COUNT
    assert clip.notices == ("gt_masks/ holds files that belong to no frame: 000077.png",)


def test_odd_frames_are_held_out_only_when_asked_for(folder):
    assert open_clip(folder).test_indices == (1, 9)
    clip = open_clip(folder, ClipOptions(split="even-odd"))
    assert clip.test_indices == (1, 3, 5, 7, 9)
    assert clip.train_indices == (0, 2, 4, 6, 8)


def test_depth_and_masks_may_be_missing(folder):
    (folder / "gt_depth").rename(folder / "depth")
    assert open_clip(folder).has_depth
    shutil.rmtree(folder / "depth")
    shutil.rmtree(folder / "gt_masks")
    clip = open_clip(folder)
    assert not clip.has_depth
    assert clip.unit == "scene units"
    assert clip.read_frame(0).tissue_mask.all()
    assert ["gt_masks" in said or "gt_depth" in said for said in clip.notices] == [True, True]


def test_inverted_masks_are_refused_unless_they_are_meant(folder):
    for path in (folder / "gt_masks").iterdir():
        Image.fromarray(np.where(np.asarray(Image.open(path)), 0, 255).astype(np.uint8)).save(path)
    assert "--mask-polarity tissue" in refusal(folder)
    meant = open_clip(folder, ClipOptions(mask_polarity="tissue")).read_frame(0)
    truth = small_frames(WHOLE)[0]
    np.testing.assert_array_equal(meant.tissue_mask, truth.tissue_mask[:, LEFT_COLUMNS:])
    forced = open_clip(folder, ClipOptions(mask_polarity="tool")).read_frame(0)
    np.testing.assert_array_equal(forced.tissue_mask, ~meant.tissue_mask)


def test_noise_of_lossy_masks_marks_nothing(folder):
    for path in list((folder / "gt_masks").iterdir()):
        tool = np.where(np.asarray(Image.open(path)), 255, 0).astype(np.uint8)
        path.unlink()
        Image.fromarray(tool).save(path.with_suffix(".jpg"))
    frames, truth = read_all(folder), small_frames(WHOLE)
    for frame, wanted in zip(frames, truth, strict=True):
        np.testing.assert_array_equal(frame.tissue_mask, wanted.tissue_mask[:, LEFT_COLUMNS:])


def test_depth_beyond_three_times_the_median_is_none(folder):
    depth = np.full((WHOLE.height, WHOLE.width), 60, np.uint16)
    depth[0, LEFT_COLUMNS : LEFT_COLUMNS + 4] = 19, 20, 180, 181
    Image.fromarray(depth).save(folder / "gt_depth/000000.png")
    read = open_clip(folder).read_frame(0).depth
    np.testing.assert_array_equal(read[0, :5], [0, 20, 180, 0, 60])


def test_lossy_masks_that_mark_nothing_for_being_dark_are_named(folder):
    for path in list((folder / "gt_masks").iterdir()):
        tool = np.where(np.asarray(Image.open(path)), 90, 0).astype(np.uint8)
        path.unlink()
        Image.fromarray(tool).save(path.with_suffix(".jpg"))
    clip = open_clip(folder)
    assert clip.read_frame(0).tissue_mask.all()
    assert any("gt_masks/ holds" in told and "marks nothing" in told for told in clip.notices)


def test_a_folder_with_poses_is_no_hamlyn_clip(folder):
    poses = np.zeros((COUNT, 17))
    poses[:, :15] = np.column_stack([np.eye(3, 4), [WHOLE.height, WHOLE.width, WHOLE.fx]]).ravel()
    np.save(folder / "poses_bounds.npy", poses)
    assert open_clip(folder).format == "endonerf"


def test_what_does_not_agree_is_refused(folder, tmp_path):
    narrow = Image.new("L", (30, 48))
    broken: dict[str, Callable[[Path], object]] = {
        "3x3": lambda path: (path / "intrinsics.txt").write_text("1 2\n3 4\n"),
        "as many numbers": lambda path: (path / "intrinsics.txt").write_text("80 0 60\nfocal\n"),
        "finite": lambda path: (path / "intrinsics.txt").write_text(""),
        "fx 0 cx": lambda path: (path / "intrinsics.txt").write_text("0 0 6\n0 8 6\n0 0 1\n"),
        "number 4": lambda path: (path / "gt_masks/000004.png").unlink(),
        "number 5": lambda path: (path / "gt_depth/000005.png").unlink(),
        "104x48": lambda path: narrow.save(path / "gt_masks/000004.png"),
        "both number 3": lambda path: shutil.copy(path / "images/000003.png", path / "images/3.png"),
        "numbers in their names": lambda path: [file.unlink() for file in (path / "images").iterdir()],
        "wider than 40": lambda path: [
            narrow.save(path / name / f"{index:06d}.png")
            for name in ("images", "gt_masks", "gt_depth")
            for index in range(COUNT)
        ],
        "one number": lambda path: shutil.copy(path / "images/000003.png", path / "gt_depth/000003.png"),
    }
    for number, (said, damage) in enumerate(broken.items()):
        copy = tmp_path / f"copy{number}"
        shutil.copytree(folder, copy)
        damage(copy)
        assert said in refusal(copy)


def test_right_images_are_cut_alike_and_give_the_depth_of_their_disparity(tmp_path):
    coarse = np.random.default_rng(0).integers(0, 255, (64, 128, 3), dtype=np.uint8)
    scene = np.asarray(Image.fromarray(coarse).resize((384, 192), Image.Resampling.BICUBIC))
    for name, start in (("images", 0), ("images_right", 6)):
        (tmp_path / name).mkdir()
        for index in range(2):
            Image.fromarray(scene[:, start : start + 320]).save(tmp_path / name / f"{index:06d}.png")
    np.savetxt(tmp_path / "intrinsics.txt", [[200, 0, 160], [0, 200, 96], [0, 0, 1]])
    clip = open_clip(tmp_path, ClipOptions(depth="stereo", baseline=5.0))
    assert clip.read_right is not None
    assert clip.read_right(1).shape == clip.read_image(1).shape == (192, 280, 3)
    depth = clip.read_frame(1).depth
    assert np.median(depth[depth > 0]) == pytest.approx(200 * 5 / 6, rel=0.02)
