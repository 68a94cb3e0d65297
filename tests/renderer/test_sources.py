"""Whatever a person points at opens as the right kind of clip, or is refused in one line."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from assets import phantom_path
from renderer.clip import ClipError
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_clip


@pytest.fixture
def pictures(tmp_path: Path) -> Path:
    folder = tmp_path / "pictures"
    folder.mkdir()
    for index in range(3):
        Image.new("RGB", (32, 24), (index, 0, 0)).save(folder / f"{index}.png")
    return folder


def test_the_embedded_phantom_opens():
    clip = open_clip(phantom_path())
    assert (clip.format, len(clip), clip.size, clip.unit) == ("endonerf", 24, (320, 256), "mm")
    assert clip.notices == ()
    assert clip.camera_is_fixed
    frame = clip.read_frame(12)
    assert 0.02 < 1 - frame.tissue_mask.mean() < 0.4
    assert frame.depth is not None
    measured = frame.depth[frame.tissue_mask]
    assert 30 < measured.min() < measured.max() < 100


def test_the_embedded_phantom_is_small():
    files = (path for path in phantom_path().rglob("*") if path.is_file())
    assert sum(path.stat().st_size for path in files) < 3 * 2**20


def test_each_kind_is_recognised(pictures):
    assert open_clip(pictures).format == "images"
    assert open_clip(pictures / "1.png").format == "image"
    video = pictures.with_name("video.avi")
    writer = cv2.VideoWriter(str(video), cv2.VideoWriter.fourcc(*"MJPG"), 25.0, (32, 24))
    writer.write(np.zeros((24, 32, 3), dtype=np.uint8))
    writer.release()
    assert open_clip(video).format == "video"


def test_a_folder_that_only_holds_images_is_a_folder_of_pictures(pictures):
    parent = pictures.with_name("parent")
    parent.mkdir()
    pictures.rename(parent / "images")
    assert open_clip(parent).format == "images"
    (parent / "masks").mkdir()
    with pytest.raises(ClipError, match=r"poses_bounds\.npy"):
        open_clip(parent)


def test_options_reach_the_reader():
    clip = open_clip(phantom_path(), ClipOptions(bottom_rows=5))
    assert not clip.read_frame(0).tissue_mask[-5:].any()


def test_a_path_may_be_text(tmp_path):
    assert len(open_clip(str(phantom_path()))) == len(open_clip(phantom_path()))
    with pytest.raises(ClipError, match="no such file or folder"):
        open_clip(str(tmp_path / "missing"))


@pytest.mark.parametrize("name", ["missing", "missing.mp4", "a/b"])
def test_a_missing_path_is_refused(tmp_path, name):
    with pytest.raises(ClipError, match="no such file or folder"):
        open_clip(tmp_path / name)


def test_an_empty_folder_and_a_text_file_are_refused(tmp_path):
    with pytest.raises(ClipError, match="expected images"):
        open_clip(tmp_path)
    for name in ("video.mp4", "notes.txt", "picture.png"):
        (tmp_path / name).write_text("hello\n" * 30)
        with pytest.raises(ClipError, match=f"{name}$"):
            open_clip(tmp_path / name)


@pytest.mark.parametrize("step", [1, 2, 3, 7])
def test_every_layout_is_thinned_the_same_way(pictures, step):
    for index in range(3, 7):
        Image.new("RGB", (32, 24), (index, 0, 0)).save(pictures / f"{index}.png")
    clip = open_clip(pictures, ClipOptions(frame_step=step))
    kept = list(range(0, 7, step))
    assert clip.labels == tuple(f"{index}.png" for index in kept)
    assert len(clip.cameras) == len(clip) == len(kept)
    for place, index in enumerate(kept):
        frame = clip.read_frame(place)
        assert (frame.index, frame.time) == (place, place / len(kept))
        assert frame.image[0, 0, 0] == clip.read_image(place)[0, 0, 0] == index
    assert clip.read_frame(-1).index == len(kept) - 1
    assert len(clip.notices) == (step > 1)
    with pytest.raises(IndexError):
        clip.read_frame(len(kept))


def test_a_thinned_video_plays_slower(tmp_path):
    writer = cv2.VideoWriter(str(tmp_path / "v.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 24.0, (32, 24))
    for _ in range(6):
        writer.write(np.zeros((24, 32, 3), dtype=np.uint8))
    writer.release()
    clip = open_clip(tmp_path / "v.avi", ClipOptions(frame_step=3))
    assert (len(clip), clip.frames_per_second) == (2, 8.0)


def test_the_split_is_the_same_for_every_layout(pictures):
    for path, count in ((pictures, 3), (phantom_path(), 24)):
        field, halves = open_clip(path), open_clip(path, ClipOptions(split="even-odd"))
        assert field.test_indices == tuple(range(1, count, 8))
        assert halves.test_indices == tuple(range(1, count, 2))
        assert sorted((*halves.test_indices, *halves.train_indices)) == list(range(count))


def test_layouts_are_told_apart_by_what_they_hold(tmp_path):
    for name, file in (
        ("scared", "data/frame_data/x"),
        ("structure", "camera_intrinsics_per_view"),
        ("stereomis", "StereoCalibration.ini"),
        ("hamlyn", "intrinsics.txt"),
    ):
        (tmp_path / name / "images").mkdir(parents=True)
        (tmp_path / name / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name / file).write_text("")
    (tmp_path / "structure/motion.yaml").write_text("")
    wanted = {
        "scared": "left_finalpass",
        "structure": "visible_view_indexes",
        "stereomis": "NNNNNNl",
        "hamlyn": "names",
    }
    for name, said in wanted.items():
        with pytest.raises(ClipError, match=said) as caught:
            open_clip(tmp_path / name)
        assert str(tmp_path / name) in str(caught.value)
