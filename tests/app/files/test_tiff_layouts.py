"""Layouts of TIFF that decoders misread: read as they are meant, or refused in a line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from app.errors import UserError
from app.files.image_files import read_image
from renderer.clip import ClipError
from renderer.readers.image_files.pictures import read_rgb
from renderer.readers.image_files.tiff_layouts import tiff_numbers
from tests.app.files.tiff_file import tiff

WHITE, BLACK, RGB, CMYK = 0, 1, 2, 5
MULTIPLIED, STRAIGHT = 1, 2
SHAPE = (6, 9)


def numbers(dtype: type, channels: int = 1) -> NDArray[Any]:
    shape = SHAPE if channels == 1 else (*SHAPE, channels)
    if np.dtype(dtype).kind == "f":
        return np.random.default_rng(0).random(shape).astype(dtype)
    return np.random.default_rng(0).integers(0, np.iinfo(dtype).max, shape, dtype=dtype, endpoint=True)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.uint32])
def test_white_as_zero_is_read_as_white(tmp_path: Path, dtype: type) -> None:
    path, image = tmp_path / "white.tif", numbers(dtype)
    path.write_bytes(tiff(image, WHITE))
    read = read_image(path)
    assert read.dtype == dtype
    assert np.array_equal(read, np.iinfo(dtype).max - image)
    if dtype is not np.uint32:
        seen = read_rgb(path)[..., 1].astype(float)
        assert np.abs(seen - read / np.iinfo(dtype).max * 255).max() <= 0.5


@pytest.mark.parametrize(("dtype", "kind"), [(np.uint8, MULTIPLIED), (np.uint8, STRAIGHT),
                                             (np.uint16, MULTIPLIED), (np.uint16, STRAIGHT)])  # fmt: skip
def test_colours_with_alpha_are_as_bright_as_without(tmp_path: Path, dtype: type, kind: int) -> None:
    path, image, full = tmp_path / "alpha.tif", numbers(dtype, 4), np.iinfo(dtype).max
    alpha = np.where(np.arange(SHAPE[1]) < 4, full, full // 2).astype(dtype)
    image[..., 3] = alpha
    stored = image.copy()
    if kind == MULTIPLIED:
        stored[..., :3] = np.rint(image[..., :3] * (alpha[:, None] / full))
    path.write_bytes(tiff(stored, RGB, extra=kind))
    read = read_image(path)
    assert np.abs(read.astype(int) - image).max() <= (0 if kind == STRAIGHT else 2)


def test_grey_with_alpha_keeps_it(tmp_path: Path) -> None:
    path, image = tmp_path / "grey.tif", numbers(np.uint8, 2)
    path.write_bytes(tiff(image, BLACK, extra=STRAIGHT))
    assert np.array_equal(read_image(path), image[..., [0, 0, 0, 1]])


def test_separate_planes_of_bytes_are_read(tmp_path: Path) -> None:
    path, image = tmp_path / "planes.tif", numbers(np.uint8, 3)
    path.write_bytes(tiff(image, RGB, separate=True))
    assert np.array_equal(read_image(path), image)
    assert np.array_equal(read_rgb(path), image)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (tiff(numbers(np.uint16, 3), RGB, separate=True), "separate planes of 16 bits"),
        (tiff(numbers(np.uint16, 2), BLACK, extra=STRAIGHT), "grey with alpha of 16 bits"),
        (tiff(numbers(np.float32), WHITE), "signed numbers or floats with white as 0"),
        (tiff(numbers(np.int16), WHITE), "signed numbers or floats with white as 0"),
    ],
)
def test_what_would_be_misread_is_refused_in_a_line(tmp_path: Path, content: bytes, said: str) -> None:
    path = tmp_path / "odd.tif"
    path.write_bytes(content)
    expected = f"^expected grey, RGB or RGBA values, got a TIFF of {said}: .*odd.tif$"
    with pytest.raises(UserError, match=expected):
        read_image(path)
    with pytest.raises(ClipError, match=expected):
        read_rgb(path)


def test_deep_cmyk_is_not_called_damaged(tmp_path: Path) -> None:
    path = tmp_path / "cmyk.tif"
    path.write_bytes(tiff(numbers(np.uint16, 4), CMYK))
    with pytest.raises(UserError, match="got a TIFF of CMYK of more than 8 bits"):
        read_image(path)


def test_a_big_tiff_tells_its_layout(tmp_path: Path) -> None:
    """Its directory has wider counts and places; a list of numbers lies elsewhere in either kind."""
    image = numbers(np.uint16)
    entries = [(256, 4, SHAPE[1]), (257, 4, SHAPE[0]), (258, 3, 16), (259, 3, 1), (262, 3, WHITE),
               (273, 16, 300), (277, 3, 1), (278, 4, SHAPE[0]), (279, 4, image.nbytes)]  # fmt: skip
    head = b"II+\0\x08\0\0\0" + (16).to_bytes(8, "little") + len(entries).to_bytes(8, "little")
    for tag, kind, value in entries:
        head += np.array([tag, kind], "<u2").tobytes() + np.array([1, value], "<u8").tobytes()
    path = tmp_path / "big.tif"
    path.write_bytes(head.ljust(300, b"\0") + image.tobytes())
    assert tiff_numbers(path, 258, 262, 273, 338) == (16, WHITE, 300, 0)
    assert np.array_equal(read_image(path), 65535 - image)
    path.write_bytes(tiff(numbers(np.uint16, 3), RGB))
    assert tiff_numbers(path, 258, 277) == (16, 3)


def test_a_directory_that_claims_too_much_says_nothing(tmp_path: Path) -> None:
    path = tmp_path / "huge.tif"
    path.write_bytes(b"II+\0\x08\0\0\0" + (16).to_bytes(8, "little") + b"\xff" * 8)
    assert tiff_numbers(path, 258) == (0,)


def test_signed_numbers_are_called_what_they_are(tmp_path: Path) -> None:
    path = tmp_path / "signed.tif"
    path.write_bytes(tiff(-1 - numbers(np.int16), BLACK))
    with pytest.raises(ClipError, match="expected an image of 8 or 16 bits, got int16 values"):
        read_rgb(path)
