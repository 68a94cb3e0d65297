"""What is written into an image file: it comes out again, others read it, and the pixels are untouched."""

from __future__ import annotations

import io
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from app.files.embedded import carried, carrying
from app.files.image_files import read_image, write_image
from app.files.provenance import ascii_json, read_provenance

FACTS = {"clip": "Gefäß 例 \U0001f52c", "numbers": list(range(20_000))}
"""More than one comment of a JPEG holds."""


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".jpeg", ".tif", ".tiff"])
@pytest.mark.parametrize("shape", [(21, 34), (21, 34, 3)])
def test_facts_and_pixels_round_trip(tmp_path: Path, suffix: str, shape: tuple[int, ...]) -> None:
    image = np.random.default_rng(1).integers(0, 255, shape, dtype=np.uint8)
    path = tmp_path / f"image{suffix}"
    write_image(path, image, FACTS, quality=90)
    assert [one.name for one in tmp_path.iterdir()] == [path.name]
    assert read_provenance(path) == FACTS
    plain = cv2.imdecode(np.frombuffer(path.read_bytes(), np.uint8), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(plain if plain.ndim == 2 else plain[..., ::-1], read_image(path))
    if suffix not in (".jpg", ".jpeg"):
        assert np.array_equal(read_image(path), image)
    with Image.open(path) as picture:
        picture.load()
        assert picture.size == (34, 21)


@pytest.mark.parametrize(
    ("dtype", "shape"), [(np.uint16, (9, 7, 3)), (np.float32, (9, 7, 3)), (np.uint8, (9, 7, 4))]
)
def test_a_tiff_of_any_kind_carries_it(tmp_path: Path, dtype: type, shape: tuple[int, ...]) -> None:
    image = (np.random.default_rng(2).random(shape) * 200).astype(dtype)
    write_image(tmp_path / "a.tiff", image, FACTS)
    assert read_provenance(tmp_path / "a.tiff") == FACTS
    assert np.array_equal(read_image(tmp_path / "a.tiff"), image)


def test_other_programs_read_it_in_its_usual_place(tmp_path: Path) -> None:
    image, facts = np.zeros((4, 5, 3), np.uint8), {"clip": "liver", "frame": 3}
    for suffix, read in (
        (".jpg", lambda one: one.info["comment"]),
        (".tif", lambda one: one.tag_v2[270].encode()),
    ):
        write_image(tmp_path / f"a{suffix}", image, facts)
        with Image.open(tmp_path / f"a{suffix}") as picture:
            text = read(picture)
        assert json.loads(text[len("vesselsplat ") :]) == facts


def test_a_jpeg_keeps_its_colour_s_resolution_at_a_quality_that_is_chosen(tmp_path: Path) -> None:
    stripes = np.zeros((64, 64, 3), np.uint8)
    stripes[:, ::2, 0] = 200
    sizes = {}
    for quality in (60, 95, 100):
        write_image(tmp_path / "a.jpg", stripes, {}, quality)
        sizes[quality] = (tmp_path / "a.jpg").stat().st_size
        assert np.abs(read_image(tmp_path / "a.jpg").astype(int) - stripes).max() < 60
    assert sizes[60] < sizes[95] < sizes[100]


def test_files_of_others_and_damaged_ones_carry_nothing() -> None:
    buffer = io.BytesIO()
    Image.new("RGB", (8, 8)).save(buffer, "TIFF", tiffinfo={270: "a microscope"})
    other = buffer.getvalue()
    assert carried(other) is None
    assert carried(b"") is None
    for suffix in (".png", ".jpg", ".tif"):
        whole = carrying(
            suffix, cv2.imencode(suffix, np.zeros((8, 8), np.uint8))[1].tobytes(), '{"a": 1}', b""
        )
        assert carried(whole) == b'{"a": 1}'
        for end in range(len(whole)):
            assert carried(whole[:end]) in (None, b"", *(b'{"a": 1}'[:n] for n in range(9)))
    # The description of another program gives way.
    assert carried(carrying(".tif", other, ascii_json({"b": 2}), b"")) == b'{"b": 2}'
