"""What is fully transparent in images is no tissue; colours stay as stored."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from renderer.clip import BoolImage, ByteImage
from renderer.readers.clip_options import ClipOptions
from renderer.readers.image_files.transparency import hides_some, visible
from renderer.readers.lenses.calibration import Calibration, LensCalibration
from renderer.sources import open_case, open_clip

ALPHA = np.full((24, 32), 255, np.uint8)
ALPHA[:6] = 1
ALPHA[:, 20:] = 0
SEEN: BoolImage = ALPHA > 0
COLORS: ByteImage = np.random.default_rng(0).integers(30, 220, (24, 32, 3), np.uint8)


def write(path: Path, alpha: ByteImage = ALPHA) -> Path:
    Image.fromarray(np.dstack((COLORS, alpha))).save(path, lossless=True)
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Three images, the second without anything transparent."""
    (tmp_path / "clip").mkdir()
    for number in range(3):
        write(tmp_path / f"clip/{number}.png", ALPHA if number != 1 else np.full_like(ALPHA, 255))
    return tmp_path / "clip"


@pytest.mark.parametrize("suffix", [".png", ".tif", ".webp"])
def test_one_image(tmp_path: Path, suffix: str) -> None:
    clip = open_clip(write(tmp_path / f"a{suffix}"))
    frame = clip.read_frame(0)
    np.testing.assert_array_equal(frame.tissue_mask, SEEN)
    np.testing.assert_array_equal(frame.evaluation_mask, SEEN)
    np.testing.assert_array_equal(frame.image[SEEN], COLORS[SEEN])
    said = "fully transparent pixels count as outside of the tissue (--alpha ignored takes them for tissue)"
    assert clip.notices == (said,)


def test_frames_of_a_folder_each_by_its_own(folder: Path) -> None:
    clip = open_clip(folder)
    masks = [clip.read_frame(index).tissue_mask for index in range(3)]
    assert [np.array_equal(mask, SEEN) for mask in masks] == [True, False, True]
    assert masks[1].all()
    np.testing.assert_array_equal(clip.every(2).read_frame(1).tissue_mask, SEEN)
    assert sum("transparent" in said for said in clip.notices) == 1


def test_as_any_other_pixel_where_that_is_asked_for(folder: Path) -> None:
    clip = open_clip(folder, ClipOptions(alpha="ignored"))
    assert all(clip.read_frame(index).tissue_mask.all() for index in range(3))
    assert clip.notices == ()


def test_masks_of_tools_count_as_well(folder: Path) -> None:
    marked = np.zeros((24, 32), np.uint8)
    marked[12:] = 255
    for number in range(3):
        Image.fromarray(marked).save(folder / f"{number}_mask.png")
    clip = open_clip(folder, ClipOptions(mask_polarity="tool"))
    np.testing.assert_array_equal(clip.read_frame(0).tissue_mask, SEEN & (marked == 0))


def test_a_palette_with_a_transparent_colour_and_one_on_its_side(tmp_path: Path) -> None:
    places = np.where(SEEN, 1, 0).astype(np.uint8)
    image = Image.fromarray(places, "P")
    image.putpalette([200, 100, 90, 90, 60, 50])
    exif = Image.Exif()
    exif[0x0112] = 6  # To be turned by 90 degrees clockwise.
    image.save(tmp_path / "a.png", transparency=0, exif=exif)
    np.testing.assert_array_equal(visible(tmp_path / "a.png"), np.rot90(SEEN, -1))


def test_nothing_is_said_where_all_is_seen(tmp_path: Path) -> None:
    clip = open_clip(write(tmp_path / "a.png", np.maximum(ALPHA, 1)))
    assert clip.read_frame(0).tissue_mask.all()
    assert clip.notices == ()
    Image.fromarray(COLORS).save(tmp_path / "b.png")
    assert visible(tmp_path / "b.png") is None
    (tmp_path / "c.png").write_bytes(b"no image")
    assert not hides_some([tmp_path / name for name in ("a.png", "b.png", "c.png")])


def test_whoever_states_what_alpha_means_reads_the_same() -> None:
    assert ClipOptions().reads_as(ClipOptions(alpha="ignored"))
    assert ClipOptions(alpha="mask").reads_as(ClipOptions())
    assert not ClipOptions(alpha="mask").reads_as(ClipOptions(alpha="ignored"))


def test_what_is_seen_goes_along_with_parts_and_a_calibration(folder: Path) -> None:
    lens = Calibration(lens=LensCalibration(fx=12, fy=12, cx=15.5, cy=11.5, distortion=(0.3, 0, 0, 0)))
    clip = open_clip(folder)
    assert clip.every(2).read_visible is not None
    np.testing.assert_array_equal(clip.every(2).read_visible(1), SEEN)
    bent = open_clip(folder, ClipOptions(calibration=lens))
    assert bent.read_visible is not None
    seen = bent.read_visible(0)
    assert not np.array_equal(seen, SEEN)
    np.testing.assert_array_equal(seen, bent.read_frame(0).tissue_mask)


def test_images_of_several_sizes(tmp_path: Path) -> None:
    write(tmp_path / "1.png")
    Image.fromarray(COLORS[:12]).save(tmp_path / "2.png")
    clip = open_case(tmp_path)
    assert not clip.has_one_size
    assert clip.read_visible is not None
    np.testing.assert_array_equal(clip.read_visible(0), SEEN)
    assert clip.read_visible(1) is None
