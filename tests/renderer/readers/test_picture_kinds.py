"""Frames are told from the depth maps and masks beside them, by name and else by content."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from renderer.readers.image_files.file_kinds import is_frame, moves
from renderer.readers.image_files.pictures import upright_size
from renderer.readers.image_folders.frames import open_images
from renderer.readers.image_folders.picture_kinds import frame_folder, kind_by_name, kinds_of
from renderer.sources import open_clip

SHAPE = (24, 32)


def image(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    noise = np.random.default_rng(len(path.name)).integers(0, 255, (*SHAPE, 3), dtype=np.uint8)
    Image.fromarray(noise).save(path)
    return path


def numbers(path: Path, kind: type = np.uint16) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.arange(SHAPE[0] * SHAPE[1]).reshape(SHAPE).astype(kind)).save(path)
    return path


def labels(path: Path, values: tuple[int, ...] = (0, 1)) -> Path:
    Image.fromarray(np.resize(np.array(values, np.uint8), SHAPE)).save(path)
    return path


def test_nothing_is_read_of_a_file_without_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files of a system's state, such as /proc/kmsg, are of that size, and reading them may wait for ever."""

    def waits(*_given: object, **_named: object) -> None:
        pytest.fail("it was opened")

    (tmp_path / "kmsg").touch()
    monkeypatch.setattr("io.open", waits)
    monkeypatch.setattr("builtins.open", waits)
    assert not is_frame(tmp_path / "kmsg")
    assert not moves(tmp_path / "kmsg")


@pytest.mark.parametrize(
    ("stem", "kind"),
    [
        ("left_depthmap_51", "depth"),
        ("frame-000001.depth", "depth"),
        ("Depth0001", "depth"),
        ("frameDepth_1", "depth"),
        ("0007_disp", "disparity"),
        ("disparity_x64_png", "disparity"),
        ("tool_mask_right", "mask"),
        ("case3-SEG-12", "mask"),
        ("labels", "mask"),
        ("left_51", None),
        ("indepth_3", None),
        ("masked", None),
        ("segment_4", None),
        ("display1", None),
        ("images", None),
    ],
)
def test_whole_words_of_a_name_say_it(stem, kind):
    assert kind_by_name(stem) == kind


def test_maps_by_name_are_no_frames(tmp_path):
    for index in (9, 10):
        image(tmp_path / f"left_{index}.png")
        image(tmp_path / f"left_depthmap_{index}.png")
        labels(tmp_path / f"left_{index}_mask.png")
    clip = open_clip(tmp_path)
    assert clip.labels == ("left_9.png", "left_10.png")
    assert sorted(notice.split(":")[0] for notice in clip.notices) == [
        "left out, depth maps beside the images",
        "left out, masks beside the images",
    ]


def test_maps_by_content_beside_colour_are_no_frames(tmp_path):
    pictures = [image(tmp_path / f"{index}.jpg") for index in (1, 2)]
    sixteen = [numbers(tmp_path / f"{index}_z.png") for index in (1, 2)]
    floats = [numbers(tmp_path / f"{index}_f.tiff", np.float32) for index in (1, 2)]
    few = [labels(tmp_path / f"{index}_tool.png", (0, 3, 7)) for index in (1, 2)]
    bits = tmp_path / "1_1stHO.png"
    Image.new("1", SHAPE[::-1]).save(bits)
    kinds = kinds_of([*pictures, *sixteen, *floats, *few, bits])
    assert kinds.frames == tuple(pictures)
    wanted = dict.fromkeys([*sixteen, *floats], "map") | dict.fromkeys([*few, bits], "mask")
    assert kinds.others == wanted


def test_grey_and_sixteen_bit_frames_without_colour_stay_frames(tmp_path):
    grey = [numbers(tmp_path / f"{index}.png") for index in (1, 2)]
    assert kinds_of(grey).frames == tuple(grey)
    beside = [image(tmp_path / "10.png"), labels(tmp_path / "11.png")]
    assert kinds_of(beside).frames == tuple(beside)


def test_where_all_would_be_maps_all_are_frames(tmp_path):
    named = [image(tmp_path / f"mask_{index}.png") for index in (1, 2)]
    assert kinds_of(named).frames == tuple(named)
    assert open_images(tmp_path).labels == ("mask_1.png", "mask_2.png")


def test_the_folder_of_frames_beside_those_of_maps(tmp_path):
    image(tmp_path / "case/input/1.png")
    assert frame_folder(tmp_path / "case") == tmp_path / "case"
    image(tmp_path / "case/mask/1.png")
    assert frame_folder(tmp_path / "case") == tmp_path / "case/input"
    image(tmp_path / "case/other/1.png")
    assert frame_folder(tmp_path / "case") == tmp_path / "case"
    image(tmp_path / "case/1.png")
    assert frame_folder(tmp_path / "case") == tmp_path / "case"


def test_what_a_file_manager_leaves_is_not_told_and_lost_links_are(tmp_path):
    image(tmp_path / "1.png")
    for name in ("Thumbs.db", ".DS_Store", "desktop.ini", "._1.png"):
        (tmp_path / name).write_text("x")
    assert open_images(tmp_path).notices == ()
    (tmp_path / "2.png").symlink_to(tmp_path / "nowhere.png")
    assert open_images(tmp_path).notices == ("left out, broken links: 2.png",)


def test_one_name_in_two_formats_is_refused(tmp_path):
    image(tmp_path / "1.png")
    image(tmp_path / "1.jpg")
    with pytest.raises(ValueError, match=r"1\.jpg and 1\.png"):
        open_images(tmp_path)


def test_a_gif_of_one_image_is_a_frame_and_a_film_is_none(tmp_path):
    image(tmp_path / "1.png")
    first, second = (Image.new("RGB", (8, 8), colour) for colour in ((200, 40, 30), (30, 40, 200)))
    first.resize(upright_size(tmp_path / "1.png")).save(tmp_path / "2.gif")
    first.save(tmp_path / "3.gif", save_all=True, append_images=[second])
    (tmp_path / "4.gif").write_bytes(b"GIF89a")
    clip = open_images(tmp_path)
    assert clip.labels == ("1.png", "2.gif")
    assert clip.read_image(1)[0, 0].tolist() == [200, 40, 30]
    assert clip.notices == ("left out, not numbered images: 3.gif, 4.gif",)
    image(tmp_path / "2.png")
    with pytest.raises(ValueError, match=r"2\.gif and 2\.png"):
        open_images(tmp_path)


def test_stills_and_texts_under_names_of_videos_do_not_move(tmp_path):
    dark, bright = (Image.new("L", (8, 8), value) for value in (0, 200))
    dark.save(tmp_path / "logo.gif")
    dark.save(tmp_path / "film.gif", save_all=True, append_images=[bright])
    (tmp_path / "code.ts").write_text("const a = 1")
    (tmp_path / "wide.ts").write_text("const a = 1", "utf-16")
    (tmp_path / "scope.ts").write_bytes(b"G@\x00\x10\x00" + bytes(183))
    assert [path.name for path in sorted(tmp_path.iterdir()) if moves(path)] == ["film.gif", "scope.ts"]
