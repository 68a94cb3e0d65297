from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from enhance import ImageError
from enhance.surround import inside
from tests.enhance.pictures import DTYPES, as_type

Image = NDArray[np.uint8]
Mask = NDArray[np.bool_]


def round_view(size: int = 120, seed: int = 0) -> tuple[Image, Mask]:
    """Tissue with a dark cavity inside a circle, noisy black around it; and the circle."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    circle = np.hypot(x, y) < 0.45 * size
    image = rng.integers(0, 12, (size, size, 3)).astype(np.uint8)
    image[circle] = (200, 120, 100)
    image[np.hypot(x - 8, y) < 12] = 0
    return image, circle


def test_the_surround_is_found_and_dark_tissue_is_not_it() -> None:
    image, circle = round_view()
    found = inside([image])
    assert not found[~circle].any()
    assert found[60, 68]  # The cavity.
    assert (found & circle).sum() > 0.85 * circle.sum()


@pytest.mark.parametrize("dtype", DTYPES)
def test_every_type_of_image_has_the_same_surround(dtype: type) -> None:
    image, _ = round_view()
    assert np.array_equal(inside([as_type(image / 255, dtype)]), inside([image]))
    grey = image.max(axis=2)
    assert np.array_equal(inside([as_type(grey / 255, dtype)]), inside([image]))


@pytest.mark.parametrize("level", [0, 60, 255])
def test_a_picture_of_one_tone_has_no_surround(level: int) -> None:
    assert inside([np.full((40, 50, 3), level, np.uint8)]).all()


def test_a_dark_corner_is_shadow_unless_it_is_large() -> None:
    image = np.full((100, 100, 3), 150, np.uint8)
    image[:9, :9] = 0
    assert inside([image]).all()
    image[:20, :20] = 0
    assert not inside([image])[:20, :20].any()


def test_one_mask_of_many_is_moved_by_neither_a_flash_nor_a_dark_moment() -> None:
    steady, circle = round_view()
    frames = [round_view(seed=seed)[0] for seed in range(5)]
    frames[1] = np.full_like(steady, 255)
    frames[3] = np.zeros_like(steady)
    assert np.mean(inside(frames) == inside([steady])) > 0.99
    assert not inside(iter(frames))[~circle].any()


def test_images_of_two_sizes_or_none_are_refused() -> None:
    with pytest.raises(ImageError, match=r"one size, got \(40, 50\)"):
        inside([np.zeros((40, 50, 3), np.uint8), np.zeros((41, 50, 3), np.uint8)])
    with pytest.raises(ImageError, match="at least one image"):
        inside([])
