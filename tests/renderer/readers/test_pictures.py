"""Picture files as clips read them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import ExifTags, Image

from renderer.readers.pictures import common_size, read_rgb

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
def test_a_turned_photo_stands_upright_in_pixels_and_in_size(tmp_path: Path, orientation: int) -> None:
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
