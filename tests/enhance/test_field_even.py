from __future__ import annotations

import cv2
import numpy as np
import pytest

from enhance.brightness import BLACK
from enhance.field_copy import low_of
from enhance.field_even import ALIKE, CORNER, EVEN, NOISE
from enhance.field_look import look_at
from tests.enhance.endoscopes import assert_found, found, outline, seen_in
from tests.enhance.pictures import as_type


@pytest.mark.parametrize("name", ["circle", "octagon", "two rectangles"])
@pytest.mark.parametrize("color", [(255, 255, 255), (10, 30, 90), (45, 46, 50)])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_a_page_or_window_around_a_field_is_surround(
    name: str, color: tuple[int, int, int], dtype: type
) -> None:
    fields = outline(name)
    image = np.where(fields[..., None], seen_in(np.ones((240, 320), bool)) // 2, np.uint8(color))
    cv2.putText(image, "Fig. 1", (3, 234), cv2.FONT_HERSHEY_SIMPLEX, 0.35, (128, 128, 128), 1)
    assert_found(found(as_type(image / 255, dtype)).mask(), fields)
    if color[0] == color[1] == color[2]:
        assert_found(found(as_type(image[..., 1] / 255, dtype)).mask(), fields)


@pytest.mark.parametrize("name", ["circle", "two rectangles"])
@pytest.mark.parametrize("color", [(250, 249, 247), (238, 230, 215), (30, 60, 120)])
@pytest.mark.parametrize("noise", [2.0, 5.0])
def test_a_page_that_was_scanned_is_surround(name: str, color: tuple[int, int, int], noise: float) -> None:
    fields = np.kron(outline(name), np.ones((3, 3), bool))
    tissue = seen_in(np.ones(fields.shape, bool)) // 2
    lamp = np.linspace(-2, 2, fields.shape[1])[:, None]
    grain = np.random.default_rng(3).normal(0, noise, tissue.shape)
    image = np.where(fields[..., None], tissue, np.array(color)) + lamp + grain
    assert_found(found(np.rint(np.clip(image, 0, 255)).astype(np.uint8)).mask(), fields)


@pytest.mark.parametrize("noise", [0.5, 4.0, 9.0])
@pytest.mark.parametrize("slope", [0, 3, 6])
@pytest.mark.parametrize("shape", [(97, 160, 3), (130, 61), (16, 16, 3)])
def test_the_colour_of_corners_is_that_of_the_sorted_values(
    shape: tuple[int, ...], slope: int, noise: float
) -> None:
    rng, told = np.random.default_rng(slope), 0
    for _ in range(40):
        lamp = slope * np.linspace(-1, 1, shape[1]).reshape(1, -1, *(1,) * (len(shape) - 2))
        page = rng.integers(20, 235) + lamp + noise * rng.normal(size=shape)
        small = np.clip(page, 0, 255).astype(np.uint8)
        expected = literally(small)
        found_one = look_at(low_of(small), small).surround
        assert (found_one is None) == (expected is None)
        assert expected is None or np.array_equal(found_one, expected)
        told += expected is not None
    assert told > 0 or noise > 4


def literally(small: np.ndarray) -> np.ndarray | None:
    """By sorting the values of each corner."""
    colors = small.reshape(*small.shape[:2], -1)
    ends = np.sort(colors[[0, 0, -1, -1], [0, -1, 0, -1]].astype(int), axis=0)
    if ends[2].max() < 255 * BLACK or (ends[2] - ends[1] > NOISE).any():
        return None
    side = max(2, min(colors.shape[:2]) // CORNER)
    near, far = slice(None, side), slice(-side, None)
    squares = [colors[rows, columns].reshape(side**2, -1) for rows in (near, far) for columns in (near, far)]
    values = np.sort(np.array(squares, int), axis=1)
    tones, eighth = values[:, side**2 // 2], side**2 // 8
    color = np.sort(tones, axis=0)[1:3].sum(axis=0) // 2
    spread = values[:, -1 - eighth] - values[:, eighth]
    alike = ((spread <= NOISE) & (abs(tones - color) <= EVEN)).all(axis=1)
    return np.asarray(color) if alike.sum() >= ALIKE else None


def test_corners_that_are_overexposed_are_field() -> None:
    y, x = np.mgrid[:240, :320]
    for lit in (x < 60, x + y < 120):
        image = np.where(lit[..., None], np.uint8(255), seen_in(np.ones((240, 320), bool)))
        assert found(image).is_whole


@pytest.mark.parametrize("width", [80, 320])
def test_a_line_across_an_even_image_is_no_field(width: int) -> None:
    image = np.full((240, width, 3), (180, 110, 100), np.uint8)
    image[:, width // 2 : width // 2 + width // 16] = (150, 80, 70)
    assert found(image).is_whole


@pytest.mark.parametrize("name", ["circle", "octagon"])
@pytest.mark.parametrize("color", [(255, 255, 255), (10, 30, 90)])
def test_an_image_on_a_page_may_have_a_dark_surround_itself(name: str, color: tuple[int, int, int]) -> None:
    field = np.zeros((400, 860), bool)
    image = np.full((400, 860, 3), color, np.uint8)
    for left in (60, 480):
        shown = np.s_[80:320, left : left + 320]
        field[shown] = outline(name)
        image[shown] = seen_in(outline(name))
        assert_found(found(image).mask(), field)
