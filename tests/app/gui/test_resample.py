from __future__ import annotations

import cv2
import moderngl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.enhancement.settable import MAX_ZOOM, MIN_ZOOM
from app.gui.drawing.textures import Textures
from app.gui.views.picture_view import PictureView, Placement
from app.gui.views.resample import NEARLY_WHOLE, OVER, SHARP_ZOOM, UNDER, striped, visible

PANE = (90.0, 70.0)


@pytest.fixture
def image() -> np.ndarray:
    return np.random.default_rng(5).integers(0, 256, (40, 60, 3), dtype=np.uint8)


def test_one_to_one_is_the_picture_itself(image: np.ndarray) -> None:
    patch = visible(image, Placement(1.0, 15.0, 15.0), PANE)
    assert patch is not None
    np.testing.assert_array_equal(patch.pixels, image)
    assert (patch.x, patch.y) == (15, 15)


def test_enlarged_pixels_are_squares(image: np.ndarray) -> None:
    patch = visible(image, Placement(8.0, 0.0, 0.0), PANE)
    assert patch is not None
    np.testing.assert_array_equal(patch.pixels, image[:9, :12].repeat(8, axis=0).repeat(8, axis=1))


def test_averaging_in_two_steps_is_averaging(image: np.ndarray) -> None:
    """A picture shown at less than half its size keeps its mean, and each part its own."""
    big = image.repeat(4, axis=0).repeat(4, axis=1)
    patch = visible(big, Placement(0.375, 0.0, 0.0), PANE)
    assert patch is not None
    assert patch.pixels.shape == (60, 90, 3)
    exact = cv2.resize(big.astype(np.float64), (90, 60), interpolation=cv2.INTER_AREA)
    assert abs(patch.pixels.mean() - exact.mean()) < 0.1
    assert np.abs(patch.pixels - exact).mean() < 4.0  # Of noise that spans all 256 levels.


def test_a_thin_line_keeps_its_share_when_made_smaller() -> None:
    """A one-pixel vessel on any column weighs the same: it neither vanishes nor flickers with the pan."""
    for column in range(20, 28):
        line = np.full((64, 64, 3), 200, np.uint8)
        line[:, column] = 0
        patch = visible(line, Placement(0.25, 0.0, 0.0), PANE)
        assert patch is not None
        missing = (200.0 - patch.pixels[8, :, 0]).sum()
        assert missing == pytest.approx(50.0, abs=1.5)


@pytest.mark.parametrize("zoom", [NEARLY_WHOLE, 0.975])
def test_a_thin_line_shown_at_nearly_its_size_keeps_its_share_nearly(zoom: float) -> None:
    weights = []
    for column in range(20, 60):
        line = np.full((8, 80, 3), 200, np.uint8)
        line[:, column] = 0
        patch = visible(line, Placement(zoom, 0.0, 0.0), PANE)
        assert patch is not None
        weights.append((200.0 - patch.pixels[3, :, 0]).sum() / 200)
    assert min(weights) > zoom - 0.02
    assert max(weights) < 1.02
    assert np.mean(weights) == pytest.approx(zoom, abs=0.01)


@given(
    st.floats(MIN_ZOOM, MAX_ZOOM), st.floats(0, 1), st.floats(0, 1), st.integers(1, 70), st.integers(1, 50)
)
def test_the_patch_lies_where_the_placement_says(
    zoom: float, x: float, y: float, width: int, height: int
) -> None:
    image = np.zeros((height, width, 3), np.uint8)
    place = PictureView(zoom, (x, y)).place((width, height), PANE)
    patch = visible(image, place, PANE)
    assert patch is not None
    rows, columns = patch.pixels.shape[:2]
    assert columns <= PANE[0] + 2 * zoom + 2
    left, right = place.offset_x, place.offset_x + zoom * width
    assert patch.x <= max(left, 0) + 1
    assert patch.x + columns >= min(right, PANE[0]) - 1
    assert patch.y + rows >= min(place.offset_y + zoom * height, PANE[1]) - 1


def test_nothing_in_sight_is_nothing_to_draw(image: np.ndarray) -> None:
    assert visible(image, Placement(SHARP_ZOOM, 1000.0, 0.0), PANE) is None


@pytest.mark.parametrize("zoom", [0.4, 1.0, 4.0])
def test_the_zebra_marks_clipped_pixels_of_both_ends_and_no_others(zoom: float) -> None:
    picture = np.full((60, 60, 3), 128, np.uint8)
    picture[:20, :, 0] = 255
    picture[40:] = 0
    place = Placement(zoom, 0.0, 0.0)
    patch, plain = striped(picture, place, PANE), visible(picture, place, PANE)
    assert patch is not None
    assert plain is not None
    for color, rows in ((OVER, slice(0, 20)), (UNDER, slice(40, 60))):
        marked = (patch.pixels == color).all(axis=2)
        inside = np.zeros_like(marked)
        inside[round(rows.start * zoom) : round(rows.stop * zoom)] = True
        assert not marked[~inside].any()
        if inside.any():
            assert 0.4 < marked[inside].mean() < 0.6
        elsewhere = ~(patch.pixels == OVER).all(axis=2) & ~(patch.pixels == UNDER).all(axis=2)
        np.testing.assert_array_equal(patch.pixels[elsewhere], plain.pixels[elsewhere])


@pytest.mark.gl
def test_a_texture_holds_the_pixels_and_is_written_once(ctx: moderngl.Context, image: np.ndarray) -> None:
    textures = Textures(ctx)
    place = Placement(1.0, 0.0, 0.0)
    first = textures.part("original", image, place, PANE)
    assert first is not None
    assert textures.part("original", image, place, PANE) is first
    assert (first.width, first.height) == (60, 40)
    other = textures.part("original", image.copy(), place, PANE)
    assert other is not None
    assert other is not first
    textures.whole("view", image[:7, :5])
    textures.whole("view", image[:5, :7])
    view = ctx.external_texture(textures.whole("view", image[2:9, 3:8]).get_tex_id(), (5, 7), 4, 0, "f1")
    held = np.frombuffer(view.read(), np.uint8).reshape(7, 5, 4)
    np.testing.assert_array_equal(held[..., :3], image[2:9, 3:8])
    assert (held[..., 3] == 255).all()
    textures.release()


def test_pixels_that_are_not_square_are_shown_in_their_shape() -> None:
    """A circle of a video for PAL television, stored 720 wide for 768, is round on the screen."""
    rows, columns = np.mgrid[:576, :720]
    stored = (np.hypot((columns + 0.5 - 360) * 16 / 15, rows + 0.5 - 288) < 200).astype(np.uint8) * 255
    pane = (900.0, 700.0)
    patch = visible(stored, PictureView(pixel_aspect=16 / 15).place((720, 576), pane), pane)
    assert patch is not None
    high, wide = np.ptp(np.argwhere(patch.pixels > 127), axis=0)
    assert abs(int(wide) - int(high)) <= 2
