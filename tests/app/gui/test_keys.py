"""The keyboard: what keys do, and when they do nothing."""

from __future__ import annotations

from imgui_bundle import imgui

from app.gui.commands.commands import sections
from app.gui.commands.keys import NAMED, Keyboard, chord
from app.gui.state.app_state import AppState
from app.gui.state.panes import pane
from renderer.gaussians import DynamicGaussians
from tests.app.gui.conftest import outside, start_live
from tests.app.gui.ui import (
    Draw,
    Ui,
    pictures,
)


def keyboard(state: AppState) -> Draw:
    """A frame of nothing but keys."""
    keys = Keyboard()
    return lambda: keys.handle(state, sections(state, outside()))


def test_keys_do_what_the_help_says(ui: Ui, opened: AppState) -> None:
    draw = keyboard(opened)
    key = imgui.Key
    ui.press(draw, key.e)
    assert not opened.enhancement.active
    ui.press(draw, key.e)
    ui.press(draw, key.mod_shift, key.w)
    assert not opened.enhancement.active
    ui.press(draw, key.period)
    assert opened.timeline.frame_index == 1
    ui.press(draw, key.comma)
    ui.press(draw, key.f)
    assert (opened.timeline.frame_index, opened.timeline.frozen_index) == (0, 0)
    ui.press(draw, key.p)
    assert opened.timeline.playing
    ui.press(draw, key.s)
    assert len(opened.window.wishes) == 1
    ui.press(draw, key._1)
    assert opened.picture.view.zoom == 1.0
    ui.press(draw, key.mod_shift, key.slash)
    assert opened.window.help_open
    ui.press(draw, key.mod_ctrl, key.e)  # Another chord than E.
    assert not opened.enhancement.active


def test_keys_of_flight_fly_and_do_nothing_else(ui: Ui, opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    draw = keyboard(opened)
    ui.press(draw, imgui.Key.g)
    assert opened.scene.viewer.flying
    ui.press(draw, imgui.Key.s, imgui.Key.a)
    free = opened.scene.viewer.free
    assert free is not None
    assert free.camera.position[0] == free.camera.position[2] < 0
    assert not opened.window.wishes
    assert not opened.scene.viewer.moving
    ui.press(draw, imgui.Key.home)
    ui.press(draw, imgui.Key.s)
    assert (opened.scene.viewer.free, len(opened.window.wishes)) == (None, 1)


def test_keys_keep_views_and_keyframes(ui: Ui, opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    draw = keyboard(opened)
    for key in (imgui.Key.b, imgui.Key.i, imgui.Key.i, imgui.Key.l):
        ui.press(draw, key)
    assert len(opened.scene.cameras.views.named) == 1
    assert len(opened.scene.cameras.views.path.keyframes) == 2
    assert opened.scene.cameras.playing


def test_space_peeks_only_while_it_is_held(ui: Ui, opened: AppState) -> None:
    draw = keyboard(opened)
    ui.io.add_key_event(imgui.Key.space, True)
    ui.frame(draw)
    assert opened.enhancement.peeking
    assert pane(opened, pictures(opened), "right").image is pictures(opened).original
    ui.io.add_key_event(imgui.Key.space, False)
    ui.frame(draw)
    assert not opened.enhancement.peeking


def test_a_key_with_shift_is_a_number_and_no_member_of_an_enum() -> None:
    # Python 3.11.2 cannot make one of two keys, and the window would not open there.
    assert type(NAMED["?"]) is int
    assert NAMED["?"] == chord("Shift+slash")
