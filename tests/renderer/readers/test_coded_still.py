"""HEIC, AVIF and JPEG 2000, which a decoder of videos reads, are images."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import ExifTags, Image, ImageOps

from app.files.image_files import is_still, read_image
from app.gui.views.clip_time import seconds_at
from renderer.clip import ClipError
from renderer.readers.image_files.pictures import upright_size
from renderer.sources import open_clip
from tests.renderer.readers.tiled_avif import tiled

NEAR = 6
"""Grey levels that are lost on the way."""


@pytest.mark.parametrize("suffix", [".avif", ".jp2", ".mp4"])
def test_one_image_without_a_time(tmp_path: Path, suffix: str) -> None:
    picture = np.repeat(np.linspace(40, 200, 64).astype(np.uint8)[None, :, None], 3, axis=2).repeat(
        48, axis=0
    )
    path = tmp_path / f"still{suffix}"
    Image.fromarray(picture).save(path, "JPEG2000" if suffix == ".jp2" else "AVIF", quality=95)
    clip = open_clip(path)
    assert (clip.format, len(clip), clip.labels, clip.size) == ("image", 1, (path.name,), (64, 48))
    assert seconds_at(clip, 0) is None
    assert is_still(path)
    assert np.array_equal(read_image(path), clip.read_image(0))
    assert np.abs(read_image(path).astype(int) - picture).max() <= NEAR


def test_a_moving_avif_is_a_video_and_a_damaged_one_is_refused(tmp_path: Path) -> None:
    frames = [Image.fromarray(np.full((48, 64, 3), level, np.uint8)) for level in (40, 120, 200)]
    frames[0].save(tmp_path / "moves.avif", save_all=True, append_images=frames[1:], duration=100)
    assert (open_clip(tmp_path / "moves.avif").format, len(open_clip(tmp_path / "moves.avif"))) == (
        "video",
        3,
    )
    (tmp_path / "cut.heic").write_bytes(b"\0\0\0\x18ftypheic" + bytes(100))
    with pytest.raises(ClipError, match="got a HEIC image"):
        open_clip(tmp_path / "cut.heic")


def test_one_of_several_tiles_is_not_shown_for_the_whole(tmp_path: Path) -> None:
    path = tiled(tmp_path / "tiles.avif", Image.fromarray(np.full((64, 64, 3), 90, np.uint8)))
    with pytest.raises(ClipError, match="expected an image in one piece, got one of 2 tiles: convert it"):
        open_clip(path)
    with pytest.raises(ClipError, match="one of 2 tiles"):
        upright_size(path)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_what_a_camera_says_of_itself_hides_no_image_and_no_orientation(
    tmp_path: Path, orientation: int
) -> None:
    picture = np.full((48, 64, 3), 90, np.uint8)
    picture[:24, :32], picture[24:, 32:] = (200, 40, 40), (40, 200, 40)
    told = Image.Exif()
    told[ExifTags.Base.Orientation], told[ExifTags.Base.Make] = orientation, "a phone"
    path = tmp_path / "still.avif"
    Image.fromarray(picture).save(path, exif=told, quality=95)
    with Image.open(path) as stored:
        upright = np.asarray(ImageOps.exif_transpose(stored).convert("RGB"))
    found = open_clip(path).read_image(0)
    assert found.shape == upright.shape
    assert np.abs(found.astype(int) - upright).max() <= NEAR
    assert np.array_equal(read_image(path), found)
