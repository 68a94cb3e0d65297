"""16-bit files whose values use fewer bits are shown over the whole range, a folder of them alike."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from renderer.clip import ClipError
from renderer.readers.clip_options import ClipOptions
from renderer.readers.image_files.used_bits import holds_deep, stretched, used_bits
from renderer.sources import open_case, open_clip
from tests.renderer.readers.test_pictures import ORIENTATIONS


def levels(most: int, shape: tuple[int, ...] = (24, 32, 3)) -> NDArray[np.uint16]:
    """Noise whose highest value is `most`."""
    image = np.random.default_rng(0).integers(0, most, shape).astype(np.uint16)
    image.flat[0] = most
    return image


def write(path: Path, image: NDArray[np.uint16], *settings: int) -> Path:
    """RGB, RGBA or grey."""
    order = image if image.ndim == 2 else image[..., [2, 1, 0, 3][: image.shape[2]]]
    assert cv2.imwrite(str(path), order, settings)
    return path


@pytest.mark.parametrize(
    ("most", "bits"), [(255, 16), (256, 10), (1023, 10), (1024, 12), (4095, 12), (4096, 16), (65535, 16)]
)
@pytest.mark.parametrize("suffix", [".png", ".tiff"])
def test_the_highest_value_tells_the_bits(tmp_path: Path, most: int, bits: int, suffix: str) -> None:
    assert used_bits([write(tmp_path / f"a{suffix}", levels(most))]) == bits
    assert used_bits([write(tmp_path / f"grey{suffix}", levels(most, (24, 32)))]) == bits


def test_alpha_does_not_tell(tmp_path: Path) -> None:
    image = np.dstack((levels(1023), np.full((24, 32), 65535, np.uint16)))
    path = write(tmp_path / "a.png", image)
    assert used_bits([path]) == 10
    assert open_clip(path).read_image(0).max() == 255


def test_8_bits_and_what_is_no_image_tell_nothing(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), np.full((8, 8, 3), 9, np.uint8))
    cv2.imwrite(str(tmp_path / "a.tiff"), np.full((8, 8), 0.01, np.float32))
    (tmp_path / "b.png").write_bytes(b"nothing")
    paths = [tmp_path / name for name in ("a.png", "a.tiff", "b.png")]
    assert used_bits([*paths, tmp_path / "missing.png"]) == 16
    assert not any(map(holds_deep, paths))


@pytest.mark.parametrize("bits", [8, 10, 12, 15])
def test_all_values_are_spread_evenly_over_the_range(bits: int) -> None:
    every = np.arange(1 << bits, dtype=np.uint16)
    assert np.array_equal(stretched(every, bits), np.rint(every / ((1 << bits) - 1) * 65535))
    assert stretched(np.array([1 << bits, 65535], np.uint16), bits).tolist() == [65535, 65535]
    assert np.array_equal(stretched(every, 16), every)


@pytest.mark.parametrize("suffix", [".png", ".tiff"])
@pytest.mark.parametrize("shape", [(24, 32, 3), (24, 32)])
def test_a_file_of_10_bits_is_shown_as_bright_as_one_of_8(
    tmp_path: Path, suffix: str, shape: tuple[int, ...]
) -> None:
    image = levels(1023, shape)
    clip = open_clip(write(tmp_path / f"a{suffix}", image))
    expected = np.rint(image / 1023 * 255)
    assert np.abs(clip.read_image(0) - (expected if len(shape) == 3 else expected[..., None])).max() <= 1
    assert clip.notices == (
        "16-bit file that uses 10 bits: shown 64 times brighter (--bits 16 shows what is stored)",
    )


def test_as_stored_where_that_is_asked_for(tmp_path: Path) -> None:
    path = write(tmp_path / "a.png", levels(1023))
    clip = open_clip(path, ClipOptions(bits=16))
    assert clip.read_image(0).max() <= 4
    assert clip.notices == ()
    assert open_clip(path, ClipOptions(bits=12)).read_image(0).max() == 64


def test_a_dark_frame_of_a_folder_does_not_flicker(tmp_path: Path) -> None:
    """The one in the middle alone would be stretched four times more."""
    frame = levels(4095)
    for number, share in enumerate((1.0, 0.2, 1.0)):
        write(tmp_path / f"{number}.png", (share * frame).astype(np.uint16))
    clip = open_clip(tmp_path)
    means = [clip.read_image(number).mean() for number in range(3)]
    assert means[1] == pytest.approx(0.2 * means[0], rel=0.02)
    assert "16-bit files that use 12 bits: shown 16 times brighter" in clip.notices[-1]


def test_a_folder_of_16_bits_with_a_black_frame_stays(tmp_path: Path) -> None:
    for number, most in enumerate((900, 60000, 900)):
        write(tmp_path / f"{number}.png", levels(most))
    clip = open_clip(tmp_path)
    assert clip.notices == ()
    assert clip.read_image(0).max() <= 4


def test_images_of_several_sizes_are_stretched_alike(tmp_path: Path) -> None:
    write(tmp_path / "1.png", levels(1023))
    write(tmp_path / "2.png", levels(400, (30, 32, 3)))
    clip = open_case(tmp_path)
    assert [int(clip.read_image(index).max()) for index in range(2)] == [255, 100]
    assert "16-bit files that use 10 bits" in clip.notices[-1]


@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_it_stands_upright(tmp_path: Path, orientation: int) -> None:
    image = levels(1023)
    path = write(tmp_path / "a.png", image)
    plain = open_clip(path).read_image(0)
    exif = b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0" + bytes((orientation, 0, 0, 0, 0, 0, 0))
    path.write_bytes(with_chunk(path.read_bytes(), b"eXIf", exif))
    clip = open_clip(path)
    assert np.array_equal(clip.read_image(0), ORIENTATIONS[orientation](plain))
    assert clip.size == clip.read_image(0).shape[1::-1]


def with_chunk(content: bytes, kind: bytes, told: bytes) -> bytes:
    """A PNG with a chunk behind its header."""

    chunk = struct.pack(">I", len(told)) + kind + told + struct.pack(">I", zlib.crc32(kind + told))
    return content[:33] + chunk + content[33:]


def test_a_truncated_file_is_damaged(tmp_path: Path) -> None:
    path = write(tmp_path / "a.png", levels(1023, (200, 200, 3)))
    path.write_bytes(path.read_bytes()[:-9000])
    with pytest.raises(ClipError, match="intact image"):
        open_clip(path, ClipOptions(bits=10)).read_image(0)


def test_whoever_states_the_bits_reads_the_same() -> None:
    assert ClipOptions().reads_as(ClipOptions(bits=16))
    assert ClipOptions(bits=10).reads_as(ClipOptions())
    assert not ClipOptions(bits=10).reads_as(ClipOptions(bits=16))
