"""Reflections and the black surround are told from tissue, whatever the size and light of the picture."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from renderer.depth.exposure import well_exposed
from renderer.phantom import Phantom, PhantomParams


def tissue(height: int, width: int) -> np.ndarray:
    """Red with a soft gradient and vessels."""
    rows, columns = np.indices((height, width))
    shade = 0.6 + 0.4 * columns / width - 0.15 * (np.sin(rows * 40 / height) > 0.8)
    return np.clip(shade[:, :, None] * [190, 95, 80], 0, 255).astype(np.uint8)


@pytest.mark.parametrize("size", [(128, 160), (512, 640)])
def test_a_reflection_is_left_out_with_its_margin_and_nothing_else(size):
    height, width = size
    picture = tissue(height, width)
    assert well_exposed(picture).all()
    spot = np.zeros(size, np.uint8)
    cv2.circle(spot, (width // 3, height // 2), width // 60, (1,), -1)
    picture[spot > 0] = [235, 225, 220]
    left_out = ~well_exposed(picture)
    assert left_out[spot > 0].all()
    near = cv2.dilate(spot, np.ones((2 * (width // 60) + 1,) * 2, np.uint8)) > 0
    assert not left_out[~near].any()


def test_the_surround_is_left_out():
    picture = tissue(120, 160)
    rows, columns = np.indices((120, 160))
    inside = (rows - 60) ** 2 + (columns - 80) ** 2 < 55**2
    picture[~inside] = [4, 3, 5]
    assert not well_exposed(picture)[~inside].any()
    assert well_exposed(picture)[inside].mean() > 0.99


def test_a_reflection_larger_than_its_surroundings_is_one():
    picture = tissue(100, 160)
    picture[:, 40:120] = 250
    assert not well_exposed(picture)[:, 40:120].any()


def test_the_phantom_shines_in_a_few_percent_of_its_picture():
    """What is left out is much brighter than what it lies in."""
    image = Phantom(PhantomParams(n_frames=1, tools=0, seed=41)).view(0).frame.image
    kept = well_exposed(image)
    assert 0.005 < 1 - kept.mean() < 0.15
    assert (image.min(axis=2)[kept] > 200).sum() == 0
