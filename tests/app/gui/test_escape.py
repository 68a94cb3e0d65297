"""Escape leaves the innermost thing, one at a time, and changes nothing else."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from app.gui.actions import (
    actions,
    camera_actions,
    clip_actions,
    edit_actions,
    floating_windows,
    guide_actions,
    live_actions,
    masking_actions,
    presenting,
    window_actions,
)
from app.gui.actions.escape import FLOATING
from app.gui.panels import about, batches, export, live, overlays, summary
from app.gui.panels.export import draw_export
from app.gui.panels.overlays import draw_help
from app.gui.panels.summary import draw_summary
from app.gui.state.app_state import AppState
from renderer.gaussians import DynamicGaussians
from tests.app.gui.conftest import start_live
from tests.app.gui.test_keys import keyboard
from tests.app.gui.ui import Shown, Ui, compare

Asks = Callable[[AppState], bool]
THINGS: tuple[tuple[Asks, Callable[[AppState], object]], ...] = (
    (lambda s: s.window.banner is not None, lambda s: actions.fail(s, "it failed")),
    (lambda s: s.window.full_screen, window_actions.toggle_full_screen),
    (lambda s: s.window.bare, window_actions.toggle_panels),
    (lambda s: s.presenting.pane is not None, presenting.toggle),
    (lambda s: s.editing.active, lambda s: setattr(s.editing, "active", True)),
    (lambda s: s.scene.viewer.flying, camera_actions.toggle_flight),
    (lambda s: s.scene.viewer.measuring, camera_actions.toggle_measuring),
    (lambda s: bool(s.editing.stroke), lambda s: edit_actions.draw_on(s, (3.0, 4.0))),
    (lambda s: s.masking.active, masking_actions.toggle),
    (lambda s: bool(s.masking.line), lambda s: setattr(s.masking, "line", ((3.0, 4.0),))),
    (lambda s: bool(s.picture.mask_tool), lambda s: clip_actions.draw_mask(s, "text")),
    (lambda s: s.batches.shown, lambda s: setattr(s.batches, "shown", True)),
    (lambda s: s.exports.shown, lambda s: setattr(s.exports, "shown", True)),
    (lambda s: s.live.choice.shown, live_actions.choose_source),
    (lambda s: s.window.help_open, lambda s: setattr(s.window, "help_open", True)),
    (lambda s: s.guide.shown, lambda s: floating_windows.toggle(s.guide)),
    (lambda s: s.about.shown, lambda s: floating_windows.toggle(s.about)),
)
"""Outermost first: whether it is open, and what opens it."""


@pytest.fixture
def editable(opened: AppState, model: DynamicGaussians) -> AppState:
    start_live(opened, model)
    assert opened.scene.model is not None
    opened.scene.model = replace(opened.scene.model, live=False)
    edit_actions.follow(opened)
    return opened


def test_escape_leaves_one_thing_at_a_time_from_the_inside_out(ui: Ui, editable: AppState) -> None:
    draw = keyboard(editable)
    for _, begin in THINGS:
        begin(editable)
    for left in range(len(THINGS), -1, -1):
        assert [is_open(editable) for is_open, _ in THINGS] == [place < left for place in range(len(THINGS))]
        assert editable.enhancement.active
        ui.press(draw, imgui.Key.escape)


def test_escape_leaves_the_window_in_front(ui: Ui, opened: AppState) -> None:
    """Whichever was opened or pressed last."""
    keys = keyboard(opened)

    def draw() -> None:
        draw_export(opened)
        draw_help(opened, ())
        draw_summary(opened, Shown())
        keys()

    opened.window.help_open = opened.exports.shown = True
    ui.frame(draw)
    opened.summary.shown = True
    ui.frame(draw)
    ui.press(draw, imgui.Key.escape)
    assert (opened.summary.shown, opened.exports.shown, opened.window.help_open) == (False, True, True)
    imgui.set_window_focus("Export")
    ui.frame(draw)
    ui.press(draw, imgui.Key.escape)
    assert (opened.exports.shown, opened.window.help_open) == (False, True)


def test_every_window_is_known_by_its_title() -> None:
    drawn = {each.TITLE for each in (about, guide_actions, live, export, summary, batches)}
    assert drawn < set(FLOATING)
    sources = inspect.getsource(overlays)
    assert all(f'begin("{title}", True' in sources for title in set(FLOATING) - drawn)


def test_escape_with_nothing_open_changes_nothing(ui: Ui, editable: AppState) -> None:
    before = repr(editable.chosen), editable.enhancement.active, editable.timeline.frame_index
    ui.press(keyboard(editable), imgui.Key.escape)
    assert (repr(editable.chosen), editable.enhancement.active, editable.timeline.frame_index) == before


def test_escape_in_the_middle_of_a_drag_leaves_the_mask_as_it_was(ui: Ui, opened: AppState) -> None:
    ui.io.config_flags |= imgui.ConfigFlags_.nav_enable_keyboard
    keys, panes = keyboard(opened), compare(opened, Shown())

    def draw() -> None:
        panes()
        keys()

    ui.frame(draw)
    clip_actions.draw_mask(opened, "text")
    ui.io.add_mouse_pos_event(200, 300)
    ui.frame(draw)
    ui.io.add_mouse_button_event(0, True)
    ui.frame(draw)
    ui.io.add_mouse_pos_event(300, 400)
    ui.frame(draw)
    assert opened.source.part.mask.text is not None
    ui.press(draw, imgui.Key.escape)
    assert opened.source.part.mask.text is None
    assert not opened.picture.mask_tool
    ui.io.add_mouse_pos_event(320, 420)
    ui.frame(draw)
    ui.io.add_mouse_button_event(0, False)
    ui.frame(draw)
    assert opened.source.part.mask.text is None
    assert not opened.window.wishes
