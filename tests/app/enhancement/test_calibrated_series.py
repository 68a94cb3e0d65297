"""Images that are enhanced as a calibration undistorts them say so, and come again from what they say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageCms

from app.enhancement.enhance_files import Setting, enhance_into
from app.errors import UserError
from app.exports.replay.again import replay
from app.files.image_files import read_image
from app.files.image_series import open_series
from enhance import EnhanceParams
from renderer.readers.clip_options import ClipOptions
from renderer.readers.lenses.calibration import Calibration
from renderer.readers.lenses.straightening import straightening
from tests.renderer.raw_eyes import EYES, LEFT, SIZE, raw_pairs

OPTIONS = ClipOptions(calibration=Calibration(lens=LEFT))
SETTING = Setting("paper", EnhanceParams(d_factor=0.5), clip_options=OPTIONS)


@pytest.fixture(scope="module")
def image() -> np.ndarray:
    return raw_pairs(1)[0][0]


@pytest.fixture
def folder(tmp_path: Path, image: np.ndarray) -> Path:
    (tmp_path / "clip").mkdir()
    for at in range(3):
        Image.fromarray(image).save(tmp_path / "clip" / f"{at}.png")
    return tmp_path / "clip"


def test_a_folder_is_undistorted_enhanced_and_made_again(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    list(enhance_into(out, open_series(folder, OPTIONS), SETTING))
    made = sorted(out.glob("*.png"))
    assert len(made) == 3
    plain = tmp_path / "plain"
    list(enhance_into(plain, open_series(folder), Setting("paper", EnhanceParams(d_factor=0.5))))
    assert not np.array_equal(read_image(made[0]), read_image(plain / made[0].name))
    assert replay(made[0], (folder,), tmp_path / "again.png").difference.is_none


def test_a_still_keeps_its_levels_and_is_straight(folder: Path, image: np.ndarray) -> None:
    deep = folder / "deep.npy"
    np.save(deep, image.astype(np.uint16) * 257)
    read = open_series(deep, OPTIONS).read(0)
    assert read.dtype == np.uint16
    straight = straightening(LEFT, SIZE).image(image)
    assert np.abs(read / 257 - straight).max() < 1
    np.testing.assert_array_equal(open_series(folder / "0.png", OPTIONS).read(0), straight)


def test_a_still_of_another_shape_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    Image.fromarray(np.zeros((100, 300, 3), np.uint8)).save(path)
    with pytest.raises(UserError, match="got one of 320x256, the images are 300x100"):
        open_series(path, ClipOptions(calibration=EYES)).read(0)


def test_colours_stay_those_of_each_file(folder: Path, tmp_path: Path) -> None:
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    with Image.open(folder / "1.png") as image:
        image.copy().save(folder / "1.png", icc_profile=profile)
    series = open_series(folder, OPTIONS)
    assert series.files == tuple(folder / f"{at}.png" for at in range(3))
    list(enhance_into(tmp_path / "out", series, SETTING))
    for name, expected in (("0.png", None), ("1.png", profile)):
        with Image.open(tmp_path / "out" / name) as made:
            assert made.info.get("icc_profile") == expected
    assert replay(tmp_path / "out/1.png", (folder,), tmp_path / "again.png").difference.is_none
