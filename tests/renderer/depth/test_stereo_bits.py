"""Both eyes of 16-bit images are read by the bits that the left ones use."""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from renderer.clip import ClipError
from renderer.depth.stereo_depth import with_stereo_depth
from renderer.depth.stereo_pairs import right_eye
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_bare, open_clip
from tests.renderer.depth.test_stereo_pairs import FIELD_OF_VIEW, LAYOUTS, SIZE, opened
from tests.renderer.eyes import write_eyes


def test_both_eyes_are_read_by_the_bits_that_the_left_images_use(tmp_path: Path) -> None:
    """Of a camera of 12 bits, where the folder of the left eye is opened alone."""
    folder, before = tmp_path / "written", tmp_path / "clip"
    write_eyes(folder, *LAYOUTS["folders"], count=2, **SIZE)
    for path in folder.rglob("*.png"):
        deep = before / path.relative_to(folder)
        deep.parent.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(deep), 16 * cv2.imread(str(path)).astype(np.uint16))
    clip = open_bare(before / "left", ClipOptions(field_of_view=FIELD_OF_VIEW))
    assert (clip.format, clip.bits) == ("images", 12)
    left, right = clip.read_image(0), right_eye(clip).read(0)
    assert abs(right.mean() / left.mean() - 1) < 0.1
    depth = with_stereo_depth(clip, right_eye(clip), None).read_frame(0).depth
    assert np.mean(depth > 0) == pytest.approx(np.mean(opened(folder).read_frame(0).depth > 0), abs=0.02)


def test_left_and_right_images_are_read_by_the_bits_that_are_stated(tmp_path: Path) -> None:
    write_eyes(folder := tmp_path / "clip", *LAYOUTS["folders"], count=2, **SIZE)
    for path in folder.rglob("*.png"):
        cv2.imwrite(str(path), 16 * cv2.imread(str(path)).astype(np.uint16))
    stored, stated = open_bare(folder), open_bare(folder, ClipOptions(bits=12))
    assert {clip.format for clip in (stored, stated)} == {"images"}
    assert [right_eye(clip) is not None for clip in (stored, stated)] == [True, True]
    for clip in (stored, stated):
        assert clip.read_image(0).mean() == pytest.approx(right_eye(clip).read(0).mean(), rel=0.1)
    assert stated.read_image(0).mean() == pytest.approx(16 * stored.read_image(0).mean(), rel=0.1)
    assert (stored.bits, stated.bits) == (16, 12)
    said = "16-bit files that use 12 bits: shown as stored (--bits 12 shows them 16 times brighter)"
    assert said in stored.notices
    with pytest.raises(ClipError, match=re.escape(f"(20 are needed); {said}: {folder}")):
        with_stereo_depth(stored, right_eye(stored), None)
    assert "16-bit files that use 12 bits: shown 16 times brighter" in stated.notices[0]


@pytest.mark.parametrize("layout", ["suffix", "letter"])
def test_dark_pairs_in_one_folder_are_known_as_such_and_read_by_the_bits_that_they_use(
    tmp_path: Path, layout: str
) -> None:
    """As stored they show nothing that both eyes have in common, and were frames one after the other."""
    write_eyes(folder := tmp_path / "clip", *LAYOUTS[layout], count=2, **SIZE)
    bright = opened(folder).read_frame(0)
    for path in folder.iterdir():
        cv2.imwrite(str(path), 16 * cv2.imread(str(path)).astype(np.uint16))
    clip = open_clip(folder, ClipOptions(field_of_view=FIELD_OF_VIEW))
    assert (len(clip), clip.bits, clip.depth_origin) == (2, 12, "stereo")
    assert any("16-bit files that use 12 bits: shown 16 times brighter" in said for said in clip.notices)
    frame = clip.read_frame(0)
    assert frame.image.mean() == pytest.approx(bright.image.mean(), rel=0.02)
    assert frame.depth is not None
    assert bright.depth is not None
    assert np.mean(frame.depth > 0) == pytest.approx(np.mean(bright.depth > 0), abs=0.02)
    stored = open_bare(folder, ClipOptions(bits=16))
    assert (len(stored), stored.bits) == (2, 16)
