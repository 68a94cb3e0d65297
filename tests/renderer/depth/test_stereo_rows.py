"""Rows of two eyes that lie apart, or whose eyes are turned: brought together, or refused."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from renderer.clip import ClipError
from renderer.depth.stereo_depth import with_stereo_depth
from renderer.depth.stereo_pairs import open_stereo_folder, right_eye
from tests.renderer.depth.test_stereo_pairs import FIELD_OF_VIEW, change, copied, opened, two_moments
from tests.renderer.eyes import BASELINE, Eyes


@pytest.fixture(scope="module")
def written(tmp_path_factory) -> tuple[Path, Eyes]:
    """left/ and right/ with two moments of the phantom."""
    return two_moments(tmp_path_factory.mktemp("rows") / "clip")


def test_eyes_that_are_turned_are_refused_with_the_figure(written, tmp_path):
    folder = copied(written, tmp_path)

    def turned(pixels):
        turn = cv2.getRotationMatrix2D((96, 72), 5, 1)
        return cv2.warpAffine(pixels, turn, (192, 144), borderMode=cv2.BORDER_REPLICATE)

    change(folder / "right/000000.png", turned)
    with pytest.raises(ClipError, match=r"rectified pair.* got [2-5]\.\d px between .*clip$"):
        opened(folder)


def test_eyes_that_are_turned_a_little_are_brought_level_by_what_they_show(written, tmp_path):
    folder, (width, height) = copied(written, tmp_path), (192, 144)

    def turned(pixels):
        turn = cv2.getRotationMatrix2D(((width - 1) / 2, (height - 1) / 2), 2, 1)
        turn[1, 2] += 3
        return cv2.warpAffine(pixels, turn, (width, height), borderMode=cv2.BORDER_REPLICATE)

    for index in range(2):
        change(folder / f"right/{index:06d}.png", turned)
    clip, known = opened(folder), opened(written[0])
    level, rows, rest = clip.notices[-3:]
    said = re.search(r"right images are turned by (\d\.\d) degrees and stretched by (-?\d\.\d) %", level)
    assert said is not None
    assert abs(float(said[1]) - 2) < 0.25
    assert abs(float(said[2])) < 1
    apart = re.search(r"rows are (\d\.\d) px apart", rows)
    assert apart is not None
    assert abs(float(apart[1]) - 3) < 0.25
    assert "doubtful" in rest
    depth, wanted = clip.read_frame(1).depth, known.read_frame(1).depth
    assert depth is not None
    assert wanted is not None
    both = (depth > 0) & (wanted > 0)
    assert both.sum() > 0.9 * (wanted > 0).sum()
    # The turn leaves sideways shifts of up to a pixel of a disparity of about 11.
    assert np.median(np.abs(depth[both] / wanted[both] - 1)) < 0.03
    calibrated = replace(open_stereo_folder(folder, FIELD_OF_VIEW), calibrated=True)
    with pytest.raises(ClipError, match="rectified pair"):
        with_stereo_depth(calibrated, right_eye(calibrated), BASELINE)


def test_rows_that_are_apart_by_another_distance_in_each_frame_are_brought_together(written, tmp_path):
    """As of eyes that do not look at the same moment while the camera moves."""
    folder = copied(written, tmp_path)
    change(folder / "right/000000.png", lambda pixels: np.roll(pixels, 4, axis=0))
    clip, straight = opened(folder), opened(written[0])
    assert "a distance that varies" in clip.notices[-2]
    for index in range(2):
        found, wanted = clip.read_frame(index).depth, straight.read_frame(index).depth
        both = (found > 0) & (wanted > 0)
        assert both.mean() > 0.85 * (wanted > 0).mean()
        assert np.median(np.abs(found / np.where(both, wanted, 1) - 1)[both]) < 0.01


def test_rows_that_come_apart_later_are_brought_together(written, tmp_path):
    folder = copied(written, tmp_path)
    change(folder / "right/000001.png", lambda pixels: np.roll(pixels, 5, axis=0))
    clip, straight = opened(folder), opened(written[0])
    assert "a distance that varies" in clip.notices[-2]
    found, wanted = clip.read_frame(1).depth, straight.read_frame(1).depth
    both = (found > 0) & (wanted > 0)
    assert both.mean() > 0.85 * (wanted > 0).mean()
    assert np.median(np.abs(found / np.where(both, wanted, 1) - 1)[both]) < 0.01
