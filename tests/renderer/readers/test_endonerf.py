"""EndoNeRF folders: what is written comes back, and what does not agree is refused in one line."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from renderer.readers.clip_options import ClipOptions
from renderer.readers.data_sets.endonerf import open_endonerf, write_endonerf
from renderer.sources import open_clip
from tests.renderer.readers.endonerf_folders import HEIGHT, WIDTH, make_frames
from tests.renderer.small_clip import COUNT, refusal


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    path = tmp_path / "clip"
    write_endonerf(path, make_frames())
    return path


def edit_poses(folder: Path, change) -> None:
    rows = np.load(folder / "poses_bounds.npy")
    np.save(folder / "poses_bounds.npy", change(rows))


@pytest.mark.parametrize("angle", [0.0, 0.02])
def test_what_is_written_comes_back(tmp_path, angle):
    frames = make_frames(angle)
    write_endonerf(tmp_path / "clip", frames)
    clip = open_endonerf(tmp_path / "clip")
    assert (len(clip), clip.size, clip.has_depth, clip.unit) == (COUNT, (WIDTH, HEIGHT), True, "mm")
    assert clip.camera_is_fixed == (angle == 0)
    for index in (0, 4, COUNT - 1):
        frame, wanted = clip.read_frame(index), frames[index]
        assert frame.depth is not None
        assert wanted.depth is not None
        np.testing.assert_array_equal(frame.image, wanted.image)
        np.testing.assert_array_equal(clip.read_image(index), wanted.image)
        np.testing.assert_array_equal(frame.tissue_mask, wanted.tissue_mask)
        np.testing.assert_array_equal(frame.depth > 0, wanted.depth > 0)
        assert np.abs(frame.depth - wanted.depth).max() <= 1 / 64
        assert frame.time == index / COUNT
        np.testing.assert_allclose(
            frame.camera.camera_from_world, wanted.camera.camera_from_world, atol=1e-12
        )
        assert frame.camera.fx == wanted.camera.fx


def test_whole_millimetres_are_read_where_there_is_nothing_finer(folder):
    shutil.rmtree(folder / "depth_fine")
    depth = open_endonerf(folder).read_frame(2).depth
    wanted = make_frames()[2].depth
    np.testing.assert_array_equal(depth, np.rint(wanted))


def test_depth_of_8_16_bits_and_floats_is_the_same_number(folder):
    shutil.rmtree(folder / "depth_fine")
    stored = np.full((HEIGHT, WIDTH), 105)
    for index, (kind, suffix) in enumerate([(np.uint8, "png"), (np.uint16, "png"), (np.float32, "tiff")]):
        (folder / f"depth/frame-{index:06d}.depth.png").unlink()
        Image.fromarray(stored.astype(kind)).save(folder / f"depth/frame-{index:06d}.depth.{suffix}")
    clip = open_endonerf(folder)
    for index in range(3):
        frame = clip.read_frame(index)
        np.testing.assert_array_equal(frame.depth, np.where(frame.tissue_mask, stored, 0))


def test_depth_that_is_no_number_is_no_measurement(folder):
    shutil.rmtree(folder / "depth_fine")
    depth = np.full((HEIGHT, WIDTH), 50.0, dtype=np.float32)
    depth[0, :3] = np.nan, np.inf, -4
    (folder / "depth/frame-000000.depth.png").unlink()
    Image.fromarray(depth).save(folder / "depth/frame-000000.depth.tiff")
    frame = open_endonerf(folder).read_frame(0)
    assert frame.depth is not None
    np.testing.assert_array_equal(frame.depth[0, :4], [0, 0, 0, 50])
    assert not frame.depth_mask[0, :3].any()


def test_a_frame_of_one_bit_a_pixel_has_no_depth(folder):
    """As programs that shrink PNGs store a map that is 0 throughout."""
    shutil.rmtree(folder / "depth_fine")
    Image.new("1", (WIDTH, HEIGHT)).save(folder / "depth/frame-000004.depth.png")
    assert not open_endonerf(folder).read_frame(4).depth_mask.any()


def test_the_split_is_the_fields(folder):
    clip = open_endonerf(folder)
    assert clip.test_indices == (1, 9)
    assert set(clip.train_indices) == set(range(COUNT)) - {1, 9}


def test_files_pair_by_number_not_by_order(folder):
    """Names that sort as 0, 1, 10, ... for depth only."""
    for number in range(COUNT):
        old = folder / f"depth_fine/frame-{number:06d}.depth.png"
        old.rename(folder / f"depth_fine/{chr(ord('z') - number)}_{number}.png")
    depth = open_endonerf(folder).read_frame(3).depth
    np.testing.assert_allclose(depth, make_frames()[3].depth, atol=1 / 64)


def test_a_stray_file_is_reported_and_not_paired(folder):
    (folder / "masks/left_video.mp4").write_bytes(b"video")
    (folder / "masks/.DS_Store").write_bytes(b"junk")
    clip = open_endonerf(folder)
    assert len(clip) == COUNT
    assert [notice for notice in clip.notices if "left_video.mp4" in notice]
    assert not [notice for notice in clip.notices if "DS_Store" in notice]


@pytest.mark.parametrize("name", ["images", "depth_fine", "masks"])
def test_a_missing_frame_is_named(folder, name):
    next((folder / name).glob("*000004*")).unlink()
    line = refusal(folder)
    assert f"{name}/ has 9 frames" in line or f"{name}/ lacks number 4" in line
    assert "10" in line
    assert "number 4" in line


def test_a_number_twice_is_refused(folder):
    shutil.copy(folder / "images/frame-000004.color.png", folder / "images/copy_4.png")
    assert "both number 4" in refusal(folder)


def test_poses_of_another_length_are_refused(folder):
    edit_poses(folder, lambda rows: rows[:-1])
    assert "images/ has 10 files but poses_bounds.npy has 9 frames" in refusal(folder)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda rows: rows[:, :15], "(frames, 17)"),
        (lambda rows: rows * np.nan, "finite"),
        (lambda rows: rows * 2, "rotations"),
        (lambda rows: rows * np.where(np.arange(17) == 14, -1, 1), "positive"),
        (lambda rows: rows.astype("U8"), "(frames, 17)"),
    ],
)
def test_bad_poses_are_refused(folder, change, said):
    edit_poses(folder, change)
    assert said in refusal(folder)


def test_poses_that_cannot_be_loaded_are_refused(folder):
    poses = folder / "poses_bounds.npy"
    poses.write_bytes(poses.read_bytes()[:100])
    assert "poses_bounds.npy" in refusal(folder)
    poses.unlink()
    assert "no such file" in refusal(folder)


def test_pickled_poses_are_never_loaded(folder):
    np.save(folder / "poses_bounds.npy", np.array([{"a": 1}], dtype=object), allow_pickle=True)
    assert "unreadable" in refusal(folder)


@pytest.mark.parametrize("share", [0.3, 0.7])
@pytest.mark.parametrize("name", ["images", "depth_fine", "masks"])
def test_a_truncated_picture_is_named(folder, name, share):
    path = next((folder / name).glob("*000003*"))
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    line = refusal(folder)
    assert path.name in line
    assert "truncated" in line


def test_a_picture_of_another_size_is_named(folder):
    Image.new("RGB", (WIDTH + 2, HEIGHT)).save(folder / "images/frame-000005.color.png")
    line = refusal(folder)
    assert "42x32" in line
    assert "frame-000005.color.png" in line


@pytest.mark.parametrize(
    ("convention", "columns"), [("opengl", ([0, 1, 2], [1, -1, -1])), ("llff", ([1, 0, 2], [1, 1, -1]))]
)
def test_pose_conventions_agree_on_the_same_camera(tmp_path, convention, columns):
    """A known rig rewritten in each convention's columns gives one camera."""
    frames = make_frames(0.05)
    write_endonerf(tmp_path / "clip", frames)
    order, signs = columns

    def rewrite(rows):
        poses = rows[:, :15].reshape(-1, 3, 5).copy()
        poses[:, :, :3] = poses[:, :, order] * signs
        return np.hstack([poses.reshape(-1, 15), rows[:, 15:]])

    edit_poses(tmp_path / "clip", rewrite)
    clip = open_endonerf(tmp_path / "clip", ClipOptions(pose_convention=convention))
    for camera, frame in zip(clip.cameras, frames, strict=True):
        np.testing.assert_allclose(camera.camera_from_world, frame.camera.camera_from_world, atol=1e-12)


def set_size(folder: Path, height: float, width: float) -> None:
    def change(rows):
        rows[:, 4], rows[:, 9] = height, width
        return rows

    edit_poses(folder, change)


def test_focal_length_follows_the_size_of_the_pictures(folder):
    set_size(folder, 2 * HEIGHT, 2 * WIDTH)
    clip = open_endonerf(folder)
    assert clip.cameras[0].fx == pytest.approx(35.0 / 2)
    assert clip.cameras[0].cx == WIDTH / 2
    assert any("scaled" in notice for notice in clip.notices)


def test_a_focal_length_that_changes_is_read_for_each_frame(folder):
    assert not any("focal length" in notice for notice in open_endonerf(folder).notices)

    def change(rows):
        rows[4:, 14] *= 2
        return rows

    edit_poses(folder, change)
    clip = open_endonerf(folder)
    assert [camera.fx for camera in clip.cameras] == [35.0] * 4 + [70.0] * 6
    assert clip.read_frame(7).camera == clip.cameras[7]
    assert "poses_bounds.npy: the focal length varies from 35 to 70 px between frames" in clip.notices


def test_a_principal_point_in_place_of_the_size_is_recognised(folder):
    set_size(folder, 15.4, 21.7)
    camera = open_clip(folder).cameras[0]
    assert (camera.fx, camera.cx, camera.cy) == (35.0, 21.7, 15.4)


def test_a_size_that_fits_nothing_is_refused(folder):
    set_size(folder, HEIGHT, 2 * WIDTH)
    assert "80x32" in refusal(folder)


def test_frames_are_not_decoded_to_open(folder, monkeypatch):
    read = []
    monkeypatch.setattr(
        "renderer.readers.data_sets.endonerf.read_rgb",
        lambda path: read.append(path) or make_frames()[0].image,
    )
    open_endonerf(folder)
    assert 0 < len(read) <= 4


def test_failed_stereo_matches_are_not_depth(folder: Path) -> None:
    """In the wild single pixels lie at twenty times the depth of the tissue around them."""
    path = sorted((folder / "depth_fine").iterdir())[1]
    before = open_endonerf(folder).read_frame(1).depth
    stored = np.array(Image.open(path))
    stored[0, 3], stored[0, 5] = 65535, 1
    Image.fromarray(stored).save(path)
    after = open_endonerf(folder).read_frame(1).depth
    assert before is not None
    assert after is not None
    assert before[0, 3] > 0
    assert after[0, 3] == after[0, 5] == 0
    before[0, 3] = before[0, 5] = 0
    assert np.array_equal(before, after)


def test_depth_that_is_just_three_times_the_median_is_none(folder: Path) -> None:
    shutil.rmtree(folder / "depth_fine")
    depth = np.full((HEIGHT, WIDTH), 60, np.uint8)
    depth[0, :4] = 20, 21, 179, 180
    Image.fromarray(depth).save(folder / "depth/frame-000000.depth.png")
    read = open_endonerf(folder).read_frame(0).depth
    assert read is not None
    np.testing.assert_array_equal(read[0, :5], [0, 21, 179, 0, 60])
