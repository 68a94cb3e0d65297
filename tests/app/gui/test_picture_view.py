from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.enhancement.settable import MAX_ZOOM, MIN_ZOOM
from app.gui.views.picture_view import PictureView

PICTURE, PANE = (640, 512), (470.0, 380.0)
positions = st.tuples(st.floats(0, PANE[0]), st.floats(0, PANE[1]))
views = st.builds(
    PictureView,
    st.one_of(st.none(), st.floats(MIN_ZOOM, MAX_ZOOM)),
    st.tuples(st.floats(0, 1), st.floats(0, 1)),
    st.sampled_from([1.0, 16 / 15, 64 / 45, 0.5]),
)


@pytest.mark.parametrize("aspect", [1.0, 16 / 15, 0.5])
def test_fit_shows_the_whole_picture_centred(aspect: float) -> None:
    place = PictureView(2.0, (0.1, 0.2), aspect).fitted().place(PICTURE, PANE)
    assert place.zoom_x / place.zoom == pytest.approx(aspect)
    assert place.zoom_x * PICTURE[0] <= PANE[0] + 1e-9
    assert place.zoom * PICTURE[1] <= PANE[1] + 1e-9
    assert place.picture_at(PANE[0] / 2, PANE[1] / 2) == pytest.approx((320, 256))


@given(views, st.floats(0.5, 2.0), positions)
def test_zooming_keeps_what_is_under_the_pointer(
    view: PictureView, factor: float, at: tuple[float, float]
) -> None:
    before = view.place(PICTURE, PANE).picture_at(*at)
    zoomed = view.zoomed(factor, at, PICTURE, PANE)
    if all(0 < value < 1 for value in zoomed.center):  # Otherwise the picture's edge stops it.
        assert zoomed.place(PICTURE, PANE).picture_at(*at) == pytest.approx(before, abs=1e-6)


@given(views, st.floats(-50, 50), st.floats(-50, 50))
def test_panning_moves_the_picture_with_the_hand(view: PictureView, dx: float, dy: float) -> None:
    start = view.place(PICTURE, PANE)
    panned = view.panned((dx, dy), PICTURE, PANE)
    moved = panned.place(PICTURE, PANE)
    assert moved.zoom == pytest.approx(start.zoom)
    if all(0 < value < 1 for value in panned.center):
        assert (moved.offset_x, moved.offset_y) == pytest.approx(
            (start.offset_x + dx, start.offset_y + dy), abs=1e-6
        )


@given(views, st.floats(0.01, 100), positions)
def test_zoom_and_centre_stay_in_bounds(view: PictureView, factor: float, at: tuple[float, float]) -> None:
    zoomed = view.zoomed(factor, at, PICTURE, PANE).panned((1e6, -1e6), PICTURE, PANE)
    assert zoomed.zoom is not None
    assert MIN_ZOOM <= zoomed.zoom <= MAX_ZOOM
    assert all(0 <= value <= 1 for value in zoomed.center)


def test_one_to_one_is_one_pixel_for_one() -> None:
    place = PictureView(None, (0.25, 0.5)).one_to_one().place(PICTURE, PANE)
    assert place.zoom == 1.0
    assert place.picture_at(PANE[0] / 2, PANE[1] / 2) == pytest.approx((160, 256))
