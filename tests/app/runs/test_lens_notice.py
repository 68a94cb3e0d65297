"""What is said of a lens's distortion is what was told of it, and a file of what is said is read as that."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from app.runs.lens_notice import UNBENT, lens_notice, lens_of
from renderer.clip import Clip
from renderer.poses.distortion import Distortion
from renderer.poses.pictures import small_lens
from renderer.readers.clip_options import ClipOptions
from renderer.readers.lenses.calibration import Calibration
from renderer.readers.lenses.calibration_files import read_calibration
from renderer.sources import open_clip


@pytest.fixture
def clip(tmp_path: Path) -> Clip:
    (tmp_path / "clip").mkdir()
    for index in range(2):
        Image.fromarray(np.zeros((600, 800, 3), np.uint8)).save(tmp_path / "clip" / f"{index}.png")
    return open_clip(tmp_path / "clip")


def told(clip: Clip) -> Distortion:
    return Distortion(-0.2, 0.004, small_lens(clip.cameras[0]), 1.0)


def test_what_is_said_undistorts_the_images(clip: Clip, tmp_path: Path) -> None:
    said = lens_notice(clip, told(clip))
    focal = 400 / math.tan(math.radians(30))
    assert said.startswith("the lens bends straight lines")
    assert f"k1 = -0.200, standard deviation 0.004, at a focal length of {focal:.2f} px" in said
    file = tmp_path / "lens.json"
    file.write_text(said[said.index("{") : said.index("}") + 1])
    assert read_calibration(file) == Calibration(lens=lens_of(clip, told(clip)))
    options = ClipOptions(calibration=read_calibration(file))
    assert open_clip(clip.path, options).calibrated


@pytest.mark.parametrize(
    ("changed", "ending"),
    [
        ({"rigid": 0.62}, "as 38 % of the features do not agree with it"),
        ({"k1": 0.01}, "shows no distortion that is certain (k1 = 0.010, standard deviation 0.004)"),
        ({"k1": -0.6}, "shows no distortion that is certain (k1 = -0.600, standard deviation 0.004)"),
    ],
)
def test_of_one_that_is_not_certain_or_folds_images_none_is_claimed(
    clip: Clip, changed: dict[str, float], ending: str
) -> None:
    said = lens_notice(clip, replace(told(clip), **changed))
    assert said.startswith(UNBENT)
    assert said.endswith(ending)


def test_of_one_that_nobody_told_it_is_said_what_that_may_cost(clip: Clip) -> None:
    assert lens_notice(clip, None) == UNBENT
