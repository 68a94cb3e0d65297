"""Picture folders, single pictures and videos: order, exact frames, and refusals."""

from __future__ import annotations

import os
import random
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from renderer.clip import ClipError
from renderer.readers.frames import open_image, open_images, open_video
from renderer.readers.pictures import read_rgb

DATA = Path(__file__).resolve().parents[3] / "../shared/data/clips"
BITS = 7
LENGTH = 100


def numbered_picture(number: int) -> np.ndarray:
    """(64, 128, 3) uint8 with the number written as a row of white and black blocks."""
    picture = np.full((64, 128, 3), 60, dtype=np.uint8)
    for bit in range(BITS):
        picture[16:48, 18 * bit + 2 : 18 * bit + 16] = 230 if number >> bit & 1 else 10
    return picture


def number_of(picture: np.ndarray) -> int:
    blocks = [picture[22:42, 18 * bit + 5 : 18 * bit + 13].mean() > 128 for bit in range(BITS)]
    return sum(1 << bit for bit, white in enumerate(blocks) if white)


def write_video(path: Path, code: str, length: int = LENGTH) -> Path:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*code), 25.0, (128, 64))
    assert writer.isOpened()
    for number in range(length):
        writer.write(numbered_picture(number))
    writer.release()
    return path


@pytest.fixture(scope="module", params=[("a.mp4", "mp4v"), ("b.avi", "MJPG"), ("c.mkv", "mp4v")], ids=str)
def video(request, tmp_path_factory) -> Path:
    name, code = request.param
    return write_video(tmp_path_factory.mktemp("video") / name, code)


def test_any_frame_in_any_order_is_the_right_one(video):
    clip = open_video(video)
    assert (len(clip), clip.size, clip.format, clip.frames_per_second) == (LENGTH, (128, 64), "video", 25.0)
    assert not clip.has_depth
    assert clip.notices == ()
    order = [*range(LENGTH), *range(LENGTH - 1, -1, -1), *random.Random(5).choices(range(LENGTH), k=60)]
    assert [number_of(clip.read_image(index)) for index in order] == order
    frame = clip.read_frame(40)
    assert (frame.index, frame.time, number_of(frame.image)) == (40, 0.4, 40)
    assert frame.tissue_mask.all()
    assert frame.evaluation_mask.all()
    assert frame.depth is None


def test_threads_share_a_clip(video):
    clip = open_video(video)
    order = random.Random(6).choices(range(LENGTH), k=60)
    with ThreadPoolExecutor(4) as pool:
        assert [number_of(image) for image in pool.map(clip.read_image, order)] == order


def test_seeking_that_lands_elsewhere_is_noticed(video, monkeypatch):
    """A decoder whose seeks overshoot by three frames still gives the right pictures."""

    class Crooked:
        def __init__(self, *args):
            self._capture = decoder(*args)

        def __getattr__(self, name):
            return getattr(self._capture, name)

        def set(self, property, value):
            landed = value + 3 if property == cv2.CAP_PROP_POS_FRAMES else value
            return self._capture.set(property, landed)

    decoder = cv2.VideoCapture
    monkeypatch.setattr(cv2, "VideoCapture", Crooked)
    clip = open_video(video)
    order = [90, 3, 50, 97, 20]
    assert [number_of(clip.read_image(index)) for index in order] == order


@pytest.mark.parametrize(("name", "code"), [("a.avi", "MJPG"), ("b.mkv", "mp4v")])
def test_of_a_cut_video_the_whole_frames_remain(tmp_path, name, code):
    path = write_video(tmp_path / name, code)
    content = path.read_bytes()
    path.write_bytes(content[: int(0.6 * len(content))])
    clip = open_video(path)
    assert 40 < len(clip) < 70
    assert [number_of(clip.read_image(index)) for index in range(len(clip))] == list(range(len(clip)))
    assert f"{len(clip)} are whole" in clip.notices[0]
    with pytest.raises(IndexError):
        clip.read_image(len(clip))


def test_a_video_of_one_frame(tmp_path):
    clip = open_video(write_video(tmp_path / "one.avi", "MJPG", 1))
    assert len(clip) == 1
    assert clip.test_indices == ()
    assert number_of(clip.read_image(0)) == 0


@pytest.mark.parametrize("content", [b"", b"not a video\n" * 40, b"\x00\x00\x00\x18ftypisom" + bytes(300)])
def test_what_is_no_video_is_refused(tmp_path, content):
    path = tmp_path / "text.mp4"
    path.write_bytes(content)
    with pytest.raises(ClipError, match=r"neither, or damaged: .*text\.mp4$"):
        open_video(path)


def write_pictures(folder: Path, names: list[str]) -> None:
    folder.mkdir(exist_ok=True)
    for number, name in enumerate(names):
        Image.fromarray(numbered_picture(number)).save(folder / name)


def test_names_without_padding_sort_by_number(tmp_path):
    write_pictures(tmp_path / "clip", [f"{number}.png" for number in range(12)])
    clip = open_images(tmp_path / "clip")
    assert clip.labels[9:] == ("9.png", "10.png", "11.png")
    assert [number_of(clip.read_image(index)) for index in range(12)] == list(range(12))
    assert (clip.name, clip.format, clip.size, clip.has_depth) == ("clip", "images", (128, 64), False)
    assert clip.camera_is_fixed
    last = clip.read_frame(-1)
    assert (last.index, last.time, number_of(last.image)) == (11, 11 / 12, 11)


def test_strays_are_reported(tmp_path):
    write_pictures(tmp_path / "clip", ["a1.png", "a2.jpg", "cover.png"])
    (tmp_path / "clip/motion.yaml").write_text("1")
    (tmp_path / "clip/.hidden.png").write_text("1")
    clip = open_images(tmp_path / "clip")
    assert clip.labels == ("a1.png", "a2.jpg")
    assert clip.notices == ("left out, no numbered pictures: cover.png, motion.yaml",)


def test_pictures_without_numbers_alone_are_a_clip(tmp_path):
    write_pictures(tmp_path / "clip", ["left.png", "right.png"])
    assert open_images(tmp_path / "clip").labels == ("left.png", "right.png")


def test_an_empty_folder_is_refused_and_a_way_shown(tmp_path):
    with pytest.raises(ClipError, match="expected pictures"):
        open_images(tmp_path)
    write_pictures(tmp_path / "input", ["1.png"])
    with pytest.raises(ClipError, match="folders input: open one of these"):
        open_images(tmp_path)


def test_pictures_of_two_sizes_are_refused(tmp_path):
    write_pictures(tmp_path / "clip", ["1.png", "2.png"])
    Image.new("RGB", (127, 64)).save(tmp_path / "clip/3.png")
    with pytest.raises(ClipError, match=r"128x64 as 1\.png, got 127x64: .*3\.png"):
        open_images(tmp_path / "clip")


@pytest.mark.parametrize("suffix", ["png", "jpg", "tiff"])
def test_a_truncated_picture_is_refused(tmp_path, suffix):
    noise = np.random.default_rng(1).integers(0, 255, (64, 64, 3), dtype=np.uint8)
    path = tmp_path / f"1.{suffix}"
    Image.fromarray(noise).save(path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(ClipError, match=rf"1\.{suffix}$"):
        open_image(path)


def test_one_picture_is_a_clip_of_one_frame(tmp_path):
    write_pictures(tmp_path, ["7.png"])
    clip = open_image(tmp_path / "7.png")
    assert (len(clip), clip.format, clip.labels) == (1, "image", ("7.png",))
    np.testing.assert_array_equal(clip.read_frame(0).image, numbered_picture(0))
    with pytest.raises(IndexError):
        clip.read_image(1)


def test_other_kinds_of_pixels_become_rgb_bytes(tmp_path):
    grey = np.arange(256, dtype=np.uint16).reshape(16, 16)
    wanted = np.repeat(grey.astype(np.uint8)[:, :, None], 3, axis=2)
    colour = Image.fromarray(wanted)
    alpha = colour.convert("RGBA")
    alpha.putalpha(7)
    pictures = {
        "grey8.png": Image.fromarray(grey.astype(np.uint8)),
        "grey16.png": Image.fromarray(grey * 257),
        "alpha.png": alpha,
        "palette.png": colour.quantize(256),
    }
    for name, picture in pictures.items():
        picture.save(tmp_path / name)
        read = read_rgb(tmp_path / name)
        assert (read.dtype, read.shape) == (np.uint8, (16, 16, 3))
        np.testing.assert_array_equal(read, wanted, err_msg=name)


def test_floats_are_no_photo(tmp_path):
    Image.fromarray(np.zeros((4, 4), dtype=np.float32)).save(tmp_path / "1.tiff")
    with pytest.raises(ClipError, match="8 or 16 bits"):
        read_rgb(tmp_path / "1.tiff")


@pytest.mark.data
@pytest.mark.skipif(not DATA.is_dir(), reason="the clips are not there")
def test_real_clips():
    video = open_video(DATA / "laparoscopy_1280x720.mp4")
    assert (len(video), video.size, video.frames_per_second) == (250, (1280, 720), 25.0)
    ahead = video.read_image(150)
    for index in (149, 3, 200):
        video.read_image(index)
    np.testing.assert_array_equal(video.read_image(150), ahead)
    tool = open_images(DATA / "tool_clip_740x540")
    assert tool.labels == tuple(f"{index}.jpg" for index in range(31))
    sinus = open_images(DATA / "sinus_moving_camera")
    assert len(sinus) == 35
    assert "undistorted_mask.jpg" in sinus.notices[0]


def test_a_video_path_that_is_not_utf8_is_refused(tmp_path):
    """OpenCV's decoder ends the process on such a name."""
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9.mp4"))
    path.write_bytes(b"anything")
    with pytest.raises(ClipError, match="UTF-8"):
        open_video(path)
