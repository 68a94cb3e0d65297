"""Files of several pictures: that one alone is read is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from app.files.image_series import open_series
from renderer.sources import open_clip


def write(path: Path, count: int) -> Path:
    pages = [Image.fromarray(np.full((24, 32, 3), 40 * number, np.uint8)) for number in range(count)]
    pages[0].save(path, save_all=count > 1, append_images=pages[1:])
    return path


@pytest.mark.parametrize("suffix", ["tiff", "webp", "png"])
def test_that_the_first_of_several_pictures_is_read_is_told(tmp_path: Path, suffix: str) -> None:
    path = write(tmp_path / f"1.{suffix}", 3)
    for opened in (open_series(path), open_clip(path)):
        assert opened.notices == (f"of a file with several images only the first is read: 1.{suffix} of 3",)
        assert len(opened) == 1
    write(tmp_path / f"2.{suffix}", 1)
    for opened in (open_series(tmp_path), open_clip(tmp_path)):
        assert any(f"1.{suffix} of 3" in notice for notice in opened.notices)


def test_of_one_picture_a_file_nothing_is_told(tmp_path: Path) -> None:
    for name in ("1.tiff", "2.webp", "3.png", "4.jpg"):
        write(tmp_path / name, 1)
        assert open_series(tmp_path / name).notices == ()


def test_that_one_eye_of_a_stereo_pair_is_read_is_told(tmp_path: Path) -> None:
    path = tmp_path / "1.avif"
    Image.fromarray(np.full((48, 64, 3), 90, np.uint8)).save(path)
    assert open_clip(path).notices == open_series(path).notices == ()
    group = (24).to_bytes(4) + b"ster" + bytes(4) + b"".join(each.to_bytes(4) for each in (9, 2, 1, 2))
    groups = (12 + len(group)).to_bytes(4) + b"grpl" + bytes(4) + group
    path.write_bytes(path.read_bytes() + groups)
    said = ("of a stereo pair one image is read, without that of the other eye: 1.avif",)
    assert open_clip(path).notices == open_series(path).notices == open_clip(tmp_path).notices == said
    path.write_bytes(path.read_bytes().replace(b"ster", b"altr"))
    assert open_clip(path).notices == ()
