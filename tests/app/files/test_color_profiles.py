"""The ICC profile of an image goes to what is made of it, in place of the claim that it is sRGB."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageCms

from app.files.embedded import LONGEST_PROFILE
from app.files.image_files import read_image, write_image
from app.files.provenance import read_provenance
from tests.app.conftest import Call, Cli

SUFFIXES = (".png", ".jpg", ".tif")
RGB = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
"""Of any colours: what it says is not looked at, but for its kind."""
INKS = RGB[:16] + b"CMYK" + RGB[20:]


def image_with(path: Path, profile: bytes | None) -> np.ndarray:
    image = np.full((48, 64, 3), (200, 60, 50), np.uint8)
    image[::2] = (190, 70, 60)
    Image.fromarray(image).save(path, icc_profile=profile)
    return image


def profile_in(path: Path) -> bytes | None:
    with Image.open(path) as picture:
        picture.load()
        return picture.info.get("icc_profile")


@pytest.mark.parametrize("given", [*SUFFIXES, ".avif"])
@pytest.mark.parametrize("made", SUFFIXES)
def test_an_enhanced_image_keeps_the_profile(tmp_path: Path, vesselsplat: Cli, given: str, made: str) -> None:
    source, out = tmp_path / f"in{given}", tmp_path / f"out{made}"
    image_with(source, RGB)
    done: Call = vesselsplat("enhance", source, out, "--strength", "0")
    assert (done.code, done.error) == (0, "")
    assert profile_in(out) == RGB
    with Image.open(out) as picture:
        assert "srgb" not in picture.info
    assert np.abs(read_image(out).astype(int) - read_image(source)).mean() < 6
    assert read_provenance(out)["kind"] == "enhanced picture"
    again = vesselsplat("replay", out, "--source", source)
    assert again.out.rstrip().endswith("identical")


def test_images_of_a_folder_keep_each_its_own(tmp_path: Path, vesselsplat: Cli) -> None:
    (tmp_path / "in").mkdir()
    for name, profile in (("a", RGB), ("b", None), ("c", INKS)):
        image_with(tmp_path / "in" / f"{name}.png", profile)
    done: Call = vesselsplat("enhance", tmp_path / "in", tmp_path / "out")
    assert done.code == 0
    assert [profile_in(tmp_path / "out" / f"{name}.png") for name in "abc"] == [RGB, None, None]
    with Image.open(tmp_path / "out" / "b.png") as picture:
        assert picture.info["srgb"] == 0


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_long_profile_is_whole(tmp_path: Path, suffix: str) -> None:
    """In several parts of a JPEG, beside a text of several parts."""
    profile = RGB + np.random.default_rng(0).bytes(2 * LONGEST_PROFILE)
    facts = {"numbers": list(range(20_000))}
    image = image_with(tmp_path / "in.png", None)
    write_image(tmp_path / f"out{suffix}", image, facts, profile=profile)
    assert profile_in(tmp_path / f"out{suffix}") == profile
    assert read_provenance(tmp_path / f"out{suffix}") == facts


@pytest.mark.parametrize("shape", [(48, 64, 3), (48, 64, 4)])
def test_webp_carries_the_profile(tmp_path: Path, shape: tuple[int, ...]) -> None:
    image = np.random.default_rng(0).integers(0, 256, shape, np.uint8)
    write_image(tmp_path / "a.webp", image, {}, profile=RGB)
    write_image(tmp_path / "b.webp", image, {})
    assert [profile_in(tmp_path / name) for name in ("a.webp", "b.webp")] == [RGB, None]
    assert np.array_equal(read_image(tmp_path / "a.webp"), read_image(tmp_path / "b.webp"))


def test_tuned_images_and_their_sheet_keep_the_profile(tmp_path: Path, vesselsplat: Cli) -> None:
    source, out = tmp_path / "in.png", tmp_path / "out"
    image_with(source, RGB)
    done: Call = vesselsplat("tune", source, "--vary", "strength=0,1", "--out", out)
    assert (done.code, done.error) == (0, "")
    names = ("setting-000.png", "setting-001.png", "sheet.png")
    assert [profile_in(out / name) for name in names] == [RGB] * 3
    again = vesselsplat("replay", out / "sheet.png", "--source", source)
    assert again.out.rstrip().endswith("identical")


def test_what_holds_no_profile_says_so_but_of_srgb(tmp_path: Path, vesselsplat: Cli) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    wide = RGB.replace(b"sRGB", b"wide").replace("sRGB".encode("utf-16-be"), "wide".encode("utf-16-be"))
    for profile, told in ((RGB, 0), (None, 0), (wide, 1)):
        for number in range(2):
            image_with(folder / f"{number}.png", profile)
        for output in ("out.mp4", "out.bmp", "out.png"):
            source = folder if output == "out.mp4" else folder / "0.png"
            done: Call = vesselsplat("enhance", source, tmp_path / output, "--method", "clahe")
            assert done.code == 0, done.error
            assert done.error.count("ICC profile") == (told if output != "out.png" else 0), output
