"""A line above the pictures says where vessels became fainter than they were, and offers what helps."""

from __future__ import annotations

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from app.enhancement.frame_enhancer import PictureMaker
from app.gui.actions import actions, comparing
from app.gui.panels.compare import draw_fainter
from app.gui.state.app_state import AppState
from app.gui.state.panes import Fainter, fainter
from app.gui.work.measuring import Measurer
from enhance import EnhanceParams, VesselParams
from tests.app.gui.ui import Ui


@pytest.fixture
def seen(opened: AppState) -> AppState:
    """Measured: vessels became fainter."""
    assert opened.picture.pictures is not None
    (measured,) = Measurer().measure(opened.picture.pictures)
    opened.picture.measured = replace(
        measured,
        before=replace(measured.before, color_difference=5.1),
        after=replace(measured.after, color_difference=3.8),
    )
    return opened


def test_it_is_said_of_the_picture_and_setting_on_screen(seen: AppState) -> None:
    assert fainter(seen) == Fainter(5.1, 3.8)
    actions.set_params(seen, EnhanceParams(z=0.1))
    assert fainter(seen) is None


def test_it_is_not_said_of_what_is_not_shown(seen: AppState) -> None:
    seen.enhancement.active = False
    assert fainter(seen) is None
    seen.enhancement.active = True
    comparing.choose_source(seen, "right", "clahe")
    assert fainter(seen) is None


@pytest.mark.parametrize("after", [5.05, 5.2, float("nan")])
def test_it_is_not_said_where_vessels_are_as_clear_as_before(seen: AppState, after: float) -> None:
    measured = seen.picture.measured
    assert measured is not None
    seen.picture.measured = replace(measured, after=replace(measured.after, color_difference=after))
    assert fainter(seen) is None


def click(ui: Ui, seen: AppState) -> None:
    """What is offered last on the line."""
    spots: list[tuple[float, float]] = []

    def draw() -> None:
        draw_fainter(seen)
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        spots[:] = [((low.x + high.x) / 2, (low.y + high.y) / 2)]

    ui.frame(draw)
    ui.drag(draw, spots[0], spots[0])


def test_one_click_changes_to_the_preset(ui: Ui, seen: AppState) -> None:
    click(ui, seen)
    assert seen.enhancement.params == VesselParams()
    assert fainter(seen) is None


def test_the_preset_is_offered_without_brightening_and_at_last_the_frame(ui: Ui, seen: AppState) -> None:
    for before, after in ((VesselParams(), VesselParams(lift=0.0)), (VesselParams(lift=0.0), None)):
        actions.set_params(seen, before)
        assert seen.picture_request is not None
        seen.picture.pictures = list(PictureMaker().make(seen.picture_request))[-1]
        measured = seen.picture.measured
        assert measured is not None
        seen.picture.measured = replace(measured, pictures=seen.picture.pictures)
        assert fainter(seen) is not None
        click(ui, seen)
        assert seen.enhancement.active == (after is not None)
        assert after is None or seen.enhancement.params == after
