"""Picture files as clips read them."""

from __future__ import annotations

import io
import struct
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import ExifTags, Image, ImageFile

from renderer.readers.image_files.pictures import SeveralSizes, common_size, read_rgb, stored_kind

ORIENTATIONS = {
    1: lambda image: image,
    2: lambda image: image[:, ::-1],
    3: lambda image: image[::-1, ::-1],
    4: lambda image: image[::-1],
    5: lambda image: image.swapaxes(0, 1),
    6: lambda image: np.rot90(image, -1),
    7: lambda image: np.rot90(image, 2).swapaxes(0, 1),
    8: lambda image: np.rot90(image),
}
"""What is to be done with the stored pixels (EXIF 2.3, tag 0x0112)."""


@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_a_turned_frame_stands_upright_in_pixels_and_in_size(tmp_path: Path, orientation: int) -> None:
    rng = np.random.default_rng(0)
    stored = np.kron(rng.integers(0, 255, (4, 6, 3)), np.ones((16, 16, 1))).astype(np.uint8)
    exif = Image.Exif()
    exif[ExifTags.Base.Orientation] = orientation
    path = tmp_path / "photo.jpg"
    Image.fromarray(stored).save(path, exif=exif, quality=98, subsampling=0)
    expected = ORIENTATIONS[orientation](np.asarray(Image.open(path)))
    upright = read_rgb(path)
    assert np.array_equal(upright, expected)
    assert common_size([path]) == (upright.shape[1], upright.shape[0])


def png(path: Path, chunks: bytes = b"") -> Path:
    """A picture of 30x20 with more chunks between its pixels and its end."""
    buffer = io.BytesIO()
    noise = np.random.default_rng(0).integers(0, 255, (20, 30, 3), dtype=np.uint8)
    Image.fromarray(noise).save(buffer, "png")
    whole = buffer.getvalue()
    path.write_bytes(whole[:-12] + chunks + whole[-12:])
    return path


def test_sizes_are_told_by_headers_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pillow decodes a PNG to tell its EXIF: of a folder in 4K that takes minutes."""

    def load(picture: ImageFile.ImageFile) -> None:
        raise AssertionError("the pixels are decoded")

    paths = [png(tmp_path / "1.png")]
    for suffix in ("jpg", "tiff", "bmp"):
        Image.open(paths[0]).save(tmp_path / f"1.{suffix}")
        paths.append(tmp_path / f"1.{suffix}")
    monkeypatch.setattr(ImageFile.ImageFile, "load", load)
    assert common_size(paths) == (30, 20)


@pytest.mark.parametrize("orientation", ORIENTATIONS)
@pytest.mark.parametrize(("suffix", "kind"), [(".tif", np.uint8), (".tif", np.uint16), (".png", np.uint16)])
def test_so_do_tiffs_and_deep_ones(tmp_path: Path, orientation: int, suffix: str, kind: type) -> None:
    shape = (40, 60) if kind is np.uint16 else (40, 60, 3)
    stored = np.random.default_rng(0).integers(0, np.iinfo(kind).max, shape).astype(kind)
    exif = Image.Exif()
    exif[ExifTags.Base.Orientation] = orientation
    path = tmp_path / f"scan{suffix}"
    Image.fromarray(stored).save(path, exif=exif)
    upright = read_rgb(path)
    Image.fromarray(stored).save(tmp_path / f"plain{suffix}")
    assert np.array_equal(upright, ORIENTATIONS[orientation](read_rgb(tmp_path / f"plain{suffix}")))
    assert common_size([path]) == (upright.shape[1], upright.shape[0])


def test_what_an_array_holds_is_told_without_reading_it(tmp_path: Path) -> None:
    np.save(tmp_path / "depth.npy", np.zeros((1, 1000, 2000), np.float32))
    tracemalloc.start()
    told = stored_kind(tmp_path / "depth.npy")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert told == ("numbers", (2000, 1000))
    assert most < 1e6


def test_a_png_that_tells_its_orientation_after_its_pixels_is_turned(tmp_path: Path) -> None:
    exif = Image.Exif()
    exif[ExifTags.Base.Orientation] = 6
    content = exif.tobytes().removeprefix(b"Exif\0\0")
    chunk = struct.pack(">I", len(content)) + b"eXIf" + content
    chunk += struct.pack(">I", zlib.crc32(chunk[4:]))
    path = png(tmp_path / "1.png", chunk)
    assert read_rgb(path).shape == (30, 20, 3)
    assert common_size([path]) == (20, 30)


def test_the_pictures_that_differ_are_named_and_counted(tmp_path: Path) -> None:
    for name, size in (("1", (40, 20)), ("2", (30, 20)), ("3", (30, 20)), ("4", (9, 9))):
        Image.new("RGB", size).save(tmp_path / f"{name}.png")
    with pytest.raises(
        SeveralSizes, match=r"30x20 as 2\.png, got 40x20 and 9x9: 2 of 4 images \(1\.png, 4\.png\)"
    ):
        common_size(sorted(tmp_path.iterdir()))
