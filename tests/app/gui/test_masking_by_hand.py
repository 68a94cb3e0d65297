"""Tools masked with the mouse in the pane: strokes, the brush's size, and the keys meanwhile."""

from __future__ import annotations

import pytest
from imgui_bundle import imgui

from app.gui.actions import masking_actions
from app.gui.state.app_state import AppState
from tests.app.gui.test_keys import keyboard
from tests.app.gui.test_masking import begun, shown
from tests.app.gui.ui import Shown, Ui, compare


@pytest.fixture
def masking(opened: AppState) -> AppState:
    return begun(opened)


def test_a_hand_draws_in_the_pane_and_escape_takes_it_back(ui: Ui, masking: AppState) -> None:
    ui.io.config_flags |= imgui.ConfigFlags_.nav_enable_keyboard
    keys, panes = keyboard(masking), compare(masking, Shown())

    def draw() -> None:
        panes()
        keys()

    def move(x: float, y: float, button: bool | None = None) -> None:
        ui.io.add_mouse_pos_event(x, y)
        ui.frame(draw)
        if button is not None:
            ui.io.add_mouse_button_event(0, button)
            ui.frame(draw)

    ui.frame(draw)
    view = masking.picture.view
    move(200, 300, True)
    move(260, 330)
    assert shown(masking).mask.any()
    ui.press(draw, imgui.Key.escape)
    assert not shown(masking).mask.any()
    move(270, 340, False)
    assert not masking.masking.keeping
    assert masking.masking.active
    move(200, 300, True)
    move(260, 330)
    move(260, 331, False)
    assert len(masking.masking.keeping) == 1
    assert masking.picture.view == view
    radius = masking.masking.radius
    ui.press(draw, imgui.Key.right_bracket)
    assert masking.masking.radius > radius
    ui.press(draw, imgui.Key.escape)
    assert not masking.masking.active


def test_shift_and_the_wheel_size_the_brush_and_the_wheel_alone_zooms(ui: Ui, masking: AppState) -> None:
    panes, view, radius = compare(masking, Shown()), masking.picture.view, masking.masking.radius
    ui.frame(panes)
    ui.io.add_key_event(imgui.Key.mod_shift, True)
    ui.scroll(panes, (200, 300), 2)
    assert masking.masking.radius == pytest.approx(masking_actions.STEP**2 * radius)
    assert masking.picture.view == view
    ui.io.add_key_event(imgui.Key.mod_shift, False)
    ui.scroll(panes, (200, 300), 2)
    assert masking.masking.radius == pytest.approx(masking_actions.STEP**2 * radius)
    assert masking.picture.view != view
