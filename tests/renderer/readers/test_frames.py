"""Picture folders and single pictures: order, exact frames, and refusals."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from renderer.clip import ClipError
from renderer.readers.image_files.file_kinds import natural_key
from renderer.readers.image_files.pictures import read_rgb
from renderer.readers.image_folders.frames import open_image, open_images
from tests.renderer.readers.numbered import number_of, numbered_picture

DATA = Path(__file__).resolve().parents[3] / "../shared/data/clips"


def write_pictures(folder: Path, names: list[str]) -> None:
    folder.mkdir(exist_ok=True)
    for number, name in enumerate(names):
        Image.fromarray(numbered_picture(number)).save(folder / name)


def test_names_of_one_number_have_one_order_however_they_are_listed():
    names = [Path(name) for name in ("001.png", "01.png", "1.png", "2.png")]
    assert all(sorted(listed, key=natural_key) == names for listed in permutations(names))


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
    write_pictures(tmp_path / "clip", ["a1.png", "a2.jpg", "a3.png", "cover.png"])
    (tmp_path / "clip/motion.yaml").write_text("1")
    (tmp_path / "clip/.hidden.png").write_text("1")
    clip = open_images(tmp_path / "clip")
    assert clip.labels == ("a1.png", "a2.jpg", "a3.png")
    assert clip.notices == ("left out, not numbered images: cover.png, motion.yaml",)


def test_a_case_in_which_only_some_names_have_numbers_is_whole(tmp_path):
    write_pictures(tmp_path / "clip", ["IMG 1.jpg", "biopsy.png", "deep16.png"])
    clip = open_images(tmp_path / "clip")
    assert clip.labels == ("IMG 1.jpg", "biopsy.png", "deep16.png")
    assert clip.notices == ()


def test_pictures_without_numbers_alone_are_a_clip(tmp_path):
    write_pictures(tmp_path / "clip", ["left.png", "right.png"])
    assert open_images(tmp_path / "clip").labels == ("left.png", "right.png")


def test_a_few_names_with_a_digit_leave_out_no_others(tmp_path):
    write_pictures(tmp_path / "clip", ["b.png", "case 1.png", "d.png", "deep.png", "scan16.png"])
    clip = open_images(tmp_path / "clip")
    assert clip.labels == ("b.png", "case 1.png", "d.png", "deep.png", "scan16.png")
    assert clip.notices == ()


def test_an_empty_folder_is_refused_and_a_way_shown(tmp_path):
    with pytest.raises(ClipError, match="expected images"):
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
    with pytest.raises(IndexError, match="expected a frame from 0 to 0, got 1"):
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


def test_floats_are_no_frame(tmp_path):
    Image.fromarray(np.zeros((4, 4), dtype=np.float32)).save(tmp_path / "1.tiff")
    with pytest.raises(ClipError, match="8 or 16 bits"):
        read_rgb(tmp_path / "1.tiff")


@pytest.mark.data
@pytest.mark.skipif(not DATA.is_dir(), reason="the clips are not there")
def test_real_clips():
    tool = open_images(DATA / "tool_clip_740x540")
    assert tool.labels == tuple(f"{index}.jpg" for index in range(31))
    sinus = open_images(DATA / "sinus_moving_camera")
    assert len(sinus) == 35
    assert "undistorted_mask.jpg" not in sinus.labels


def test_a_folder_of_exported_splats_says_what_to_open(tmp_path: Path) -> None:
    for index in range(7):
        (tmp_path / f"{index:04d}.ply").touch()
    with pytest.raises(ClipError) as raised:
        open_images(tmp_path)
    said = str(raised.value)
    assert "got none; it holds the splat files 0000.ply, 0001.ply, " in said
    assert "0004.ply and 2 more: " in said
    assert said.endswith(f"open one of these, or the run that they were exported from: {tmp_path}")
