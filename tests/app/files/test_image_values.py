"""Images of uncommon values: what is read and written means what the file said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.files.image_files import read_image, write_image
from tests.app.conftest import Call
from tests.app.files.test_video import Cli


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
