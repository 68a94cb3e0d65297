"""Images of uncommon values: what is read and written means what the file said."""

from __future__ import annotations

import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from app.files.image_files import read_image, write_image
from renderer.readers.image_files.pictures import read_rgb
from tests.app.conftest import Call, Cli


@pytest.mark.parametrize("dtype", [np.float16, np.float64])
@pytest.mark.parametrize("shape", [(5, 6), (5, 6, 3), (5, 6, 4)])
def test_a_tiff_keeps_the_values_of_all_floats(tmp_path: Path, dtype: type, shape: tuple[int, ...]) -> None:
    image = np.random.default_rng(0).random(shape).astype(dtype)
    write_image(tmp_path / "image.tiff", image, {})
    read = read_image(tmp_path / "image.tiff")
    assert read.dtype == (np.float32 if dtype == np.float16 else np.float64)
    assert np.array_equal(read, image)


@pytest.mark.parametrize("dtype", [np.float16, np.float64])
@pytest.mark.parametrize("shape", [(48, 64), (48, 64, 3)])
def test_floats_of_any_width_are_enhanced_into_a_folder(
    tmp_path: Path, vesselsplat: Cli, dtype: type, shape: tuple[int, ...]
) -> None:
    given = np.random.default_rng(1).uniform(0.2, 0.7, shape).astype(dtype)
    np.save(tmp_path / "given.npy", given)
    done: Call = vesselsplat("enhance", tmp_path / "given.npy", tmp_path / "out", "--strength", "0")
    assert (done.code, done.error) == (0, "")
    read = read_image(tmp_path / "out" / "given.tiff")
    assert read.dtype.kind == "f"
    assert np.allclose(read, given, atol=0.002)


@pytest.mark.parametrize("white", [1, 7, 100, 255, 256, 1023, 4095, 65535])
@pytest.mark.parametrize("kind", [2, 3, 5, 6])
def test_white_of_a_pgm_or_ppm_is_what_its_header_says(tmp_path: Path, kind: int, white: int) -> None:
    shape = (16, 16) if kind in (2, 5) else (16, 16, 3)
    numbers = np.random.default_rng(2).integers(0, white + 1, shape)
    numbers[0, 0], numbers[0, 1] = 0, white
    stored = numbers.astype(np.uint8 if white < 256 else ">u2").tobytes()
    body = f"{' '.join(map(str, numbers.ravel()))}\n".encode() if kind in (2, 3) else stored
    path = tmp_path / f"image.{'pgm' if len(shape) == 2 else 'ppm'}"
    path.write_bytes(f"P{kind}\n# of a camera: 9 9 9\n16 16 # wide, high\n{white}\n".encode() + body)
    read = read_image(path)
    full = np.iinfo(read.dtype).max
    assert full == (255 if white < 256 else 65535)
    assert read.shape == shape
    assert np.abs(read - numbers * (full / white)).max() <= (1 if kind in (2, 3) else 0.5 + 1e-9)
    bytes_of_rgb = read * (255 / full)
    seen = read_rgb(path).astype(float) if len(shape) == 3 else read_rgb(path)[..., 0].astype(float)
    assert np.abs(seen - bytes_of_rgb).max() <= 1.01


def test_a_tiff_of_cie_lab_is_read_as_the_colours_that_it_shows(tmp_path: Path) -> None:
    y, x = np.mgrid[:24, :40]
    shown = np.stack([6 * x, 10 * y, 3 * (x + y)], axis=2).astype(np.uint8)
    path = tmp_path / "lab.tif"
    Image.fromarray(shown).convert("LAB").save(path)
    read = read_image(path)
    assert np.abs(read.astype(int) - shown).mean() < 2
    np.testing.assert_array_equal(read, read_rgb(path))


def test_cie_lab_of_more_bits_is_refused_in_a_line(tmp_path: Path, vesselsplat: Cli) -> None:
    path = tmp_path / "lab.tif"
    path.write_bytes(cv2.imencode(".tif", np.zeros((8, 8, 3), np.uint16))[1].tobytes())
    content = path.read_bytes()
    rgb, lab = (struct.pack("<HHIHH", 262, 3, 1, kind, 0) for kind in (2, 8))
    assert content.count(rgb) == 1
    path.write_bytes(content.replace(rgb, lab))
    done: Call = vesselsplat("enhance", path, tmp_path / "out.png")
    assert done.code == 2
    assert "got a TIFF of CIE Lab" in done.error
    assert not (tmp_path / "out.png").exists()


@pytest.mark.parametrize(
    ("kind", "numbers", "shape"), [("P2", "10 250", (1, 2)), ("P3", "1 2 3 4 5 6", (1, 2, 3))]
)
@pytest.mark.parametrize("end", ["", "\n"])
def test_plain_netpbm_is_read_with_and_without_a_last_line_end(
    tmp_path: Path, kind: str, numbers: str, shape: tuple[int, ...], end: str
) -> None:
    path = tmp_path / "a.pnm"
    path.write_text(f"{kind}\n2 1\n255\n{numbers}{end}", newline="")
    expected = np.array([int(number) for number in numbers.split()], np.uint8).reshape(shape)
    np.testing.assert_array_equal(read_image(path), expected)
