"""What lies over the window: notice, banner, toast, help; and the log."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.gui.actions import actions, floating_windows
from app.gui.commands.commands import sections
from app.gui.panels import compare, overlays
from app.gui.panels.batches import draw_batches
from app.gui.panels.export import draw_export
from app.gui.state.app_state import AppState
from app.gui.style import widgets
from tests.app.gui.conftest import outside
from tests.app.gui.ui import (
    Draw,
    Shown,
    Ui,
    view3d,
)


def test_the_notice_stays_until_it_is_acknowledged(ui: Ui, state: AppState) -> None:
    state.settings = replace(state.settings, acknowledged=False)
    draw: Draw = lambda: overlays.draw_notice(state)  # noqa: E731
    for _ in range(3):
        ui.frame(draw)
    ui.press(draw, imgui.Key.escape)
    ui.frame(draw)
    assert not state.settings.acknowledged
    assert imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
    actions.acknowledge(state)
    ui.frame(draw)


def test_banner_toast_help_and_log_draw(ui: Ui, state: AppState) -> None:
    actions.fail(state, "expected a clip, got a folder without images: " + "a/long/path/" * 20)
    actions.announce(state, "saved clip.png")
    state.window.help_open = True

    def draw() -> None:
        overlays.draw_banner(state)
        overlays.draw_toast(state)
        overlays.draw_help(state, sections(state, outside()))
        overlays.draw_log(state, lambda text: None)

    for _ in range(3):
        ui.frame(draw)
    assert state.window.help_open
    np.testing.assert_equal(len(state.window.log), 2)


def test_good_news_lies_over_the_window_that_was_clicked_last(ui: Ui, state: AppState) -> None:
    actions.announce(state, "saved clip.png")
    state.window.help_open = True

    def draw() -> None:
        overlays.draw_toast(state)
        overlays.draw_help(state, sections(state, outside()))

    for _ in range(3):
        ui.frame(draw)
    ui.drag(draw, (450, 350), (450, 350))
    named, height = imgui.internal.find_window_by_name, imgui.internal.find_window_display_index
    assert height(named("##toast")) > height(named("Keys and mouse"))


def test_good_news_lies_beside_the_menus_and_over_no_list(ui: Ui, state: AppState) -> None:
    """Longer news, or larger text, is in more lines."""
    heights: list[float] = []

    def draw() -> None:
        with imgui_ctx.begin_main_menu_bar(), imgui_ctx.begin_menu("File and others"):
            pass
        heights.append(imgui.get_frame_height())
        overlays.draw_toast(state)

    def shown(sentence: str) -> imgui.internal.Window:
        actions.announce(state, sentence)
        for _ in range(4):
            ui.frame(draw)
        return imgui.internal.find_window_by_name("##toast")

    bar = imgui.internal.find_window_by_name
    toast = shown("saved clip.png")
    assert toast.pos.y == 0
    assert toast.pos.x + toast.size.x == pytest.approx(ui.io.display_size.x, abs=1)
    assert toast.size.y <= heights[-1] + 1
    assert toast.pos.x > bar("##MainMenuBar").content_size.x
    toast = shown("saved " + "clip " * 60)
    assert heights[-1] < toast.size.y < 5 * heights[-1]
    assert toast.pos.x > bar("##MainMenuBar").content_size.x


def test_the_log_keeps_the_newest_in_sight_and_gives_its_lines(ui: Ui, state: AppState) -> None:
    copied: list[str] = []
    bottoms: list[float] = []

    def draw() -> None:
        overlays.draw_log(state, copied.append)
        bottoms[:] = [imgui.get_item_rect_max().y]

    for number in range(60):
        actions.say(state, f"line {number}")
        ui.frame(draw)
    for _ in range(2):
        ui.frame(draw)
    ui.drag(draw, (30, bottoms[0] - 8), (30, bottoms[0] - 8))
    assert copied == ["line 59"]
    ui.drag(draw, (40, 20), (40, 20))
    assert copied[1].splitlines() == list(state.window.log)
    ui.scroll(draw, (40, 300), 20.0)  # Back to the first: there it stays.
    for _ in range(20):  # Scrolling glides.
        ui.frame(draw)
    actions.say(state, "line 60")
    ui.frame(draw)
    ui.drag(draw, (30, 38), (30, 38))
    assert copied[2] == "line 0"


def test_an_error_hides_no_control_of_the_images(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    tops: list[float] = []

    def seen(label: str, *rest: Any, **more: Any) -> Any:
        tops.append(imgui.get_cursor_screen_pos().y)
        return original(label, *rest, **more)

    original = widgets.button
    monkeypatch.setattr(compare, "button", seen)
    shown = Shown()

    def draw() -> None:
        tops.clear()
        compare.draw_compare(opened, shown)
        overlays.draw_banner(opened)

    for sentence in ("expected an intact image, got a damaged one", ""):
        actions.fail(opened, sentence) if sentence else actions.dismiss(opened)
        for _ in range(4):
            ui.frame(draw)
        banner = imgui.internal.find_window_by_name(overlays.BANNER)
        assert (tops[0] >= banner.pos.y + banner.size.y) == bool(sentence)


def test_an_error_hides_no_control_of_the_3d_view(
    ui: Ui, seen: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a splat file it takes the place of the images."""
    tops: list[float] = []
    monkeypatch.setattr(
        "app.gui.panels.view3d._draw_toolbar", lambda state: tops.append(imgui.get_cursor_screen_pos().y)
    )

    def draw() -> None:
        view3d(seen)
        overlays.draw_banner(seen)

    actions.fail(seen, "expected an intact image, got a damaged one")
    for _ in range(4):
        ui.frame(draw)
    banner = imgui.internal.find_window_by_name(overlays.BANNER)
    assert tops[-1] >= banner.pos.y + banner.size.y
    assert tops[0] < banner.pos.y + banner.size.y


def draw_error_and_export(state: AppState) -> None:
    overlays.draw_banner(state)
    draw_export(state)


def test_an_error_hides_nothing_of_what_floats(ui: Ui, opened: AppState) -> None:
    """Also in a low window, which the list of what can be exported fills."""
    ui.io.display_size = ImVec2(900, 480)
    floating_windows.toggle(opened.exports)
    actions.fail(opened, "expected an intact image, got a damaged one")

    draw = partial(draw_error_and_export, opened)
    for _ in range(6):
        ui.frame(draw)
    banner, export = (imgui.internal.find_window_by_name(name) for name in (overlays.BANNER, "Export"))
    assert export.pos.y >= banner.pos.y + banner.size.y
    assert export.pos.y + export.size.y <= 480


@pytest.mark.parametrize(
    ("title", "draw", "part"),
    [
        ("Export", draw_export, lambda state: state.exports),
        ("Enhance files and folders", draw_batches, lambda state: state.batches),
    ],
)
def test_what_is_closed_by_its_button_comes_back_in_the_middle(
    ui: Ui,
    opened: AppState,
    title: str,
    draw: Callable[[AppState], None],
    part: Callable[[AppState], floating_windows.Floating],
) -> None:
    """Not below it, where half of it was off the screen."""
    ui.io.display_size = ImVec2(1280, 720)

    def shown() -> tuple[float, float, float, float]:
        floating_windows.show(part(opened), True)
        for _ in range(6):
            ui.frame(lambda: draw(opened))
        window = imgui.internal.find_window_by_name(title)
        return window.pos.x, window.pos.y, window.size.x, window.size.y

    left, top, across, _ = first = shown()
    size = imgui.get_font_size()
    cross = left + across - 0.9 * size, top + 0.7 * size
    ui.drag(lambda: draw(opened), cross, cross)
    assert not part(opened).shown
    ui.frame(lambda: draw(opened))
    assert shown() == first


def test_what_floats_stays_within_a_window_that_has_become_lower(ui: Ui, opened: AppState) -> None:
    floating_windows.toggle(opened.exports)
    for height in (1000, 500):
        ui.io.display_size = ImVec2(900, height)
        for _ in range(6):
            ui.frame(lambda: draw_export(opened))
        export = imgui.internal.find_window_by_name("Export")
        assert export.size.y > 400
        assert 0 <= export.pos.y <= height - export.size.y


def test_what_an_error_has_moved_leaves_the_status_bar_free(ui: Ui, opened: AppState) -> None:
    ui.io.display_size = ImVec2(1280, 720)
    floating_windows.toggle(opened.exports)
    actions.fail(opened, "expected room on the disk, got none")

    draw = partial(draw_error_and_export, opened)
    for told in (True, False):
        if not told:
            actions.dismiss(opened)
        for _ in range(6):
            ui.frame(draw)
        export = imgui.internal.find_window_by_name("Export")
        assert export.pos.y + export.size.y <= 720 - 1.5 * imgui.get_font_size()


def test_an_error_moves_only_what_it_covers(ui: Ui, opened: AppState) -> None:
    floating_windows.toggle(opened.exports)

    draw = partial(draw_error_and_export, opened)

    def place() -> tuple[float, float]:
        for _ in range(6):
            ui.frame(draw)
        export = imgui.internal.find_window_by_name("Export")
        return export.pos.x, export.pos.y

    def moved(by: float) -> tuple[float, float]:
        x, y = place()
        ui.drag(draw, (x + 300, y + 5), (x + 300 + by, y + 5 + by))
        return place()

    before = place()
    there = moved(60)
    assert there != before
    actions.fail(opened, "expected an intact image, got a damaged one")
    assert place() == there
    assert moved(20) == (there[0] + 20, there[1] + 20)
    above = moved(-200)
    banner = imgui.internal.find_window_by_name(overlays.BANNER)
    assert above == (there[0] - 180, banner.pos.y + banner.size.y)
    actions.dismiss(opened)
    assert place() == above


def test_notes_take_what_is_typed_after_their_panel_was_asked_for(ui: Ui, state: AppState) -> None:
    shown = {"Notes": False}
    services = outside(toggle_panel=lambda name: shown.update({name: True}), panel_shown=lambda name: True)
    commands = [one for section in sections(state, services) for one in section.commands]
    next(one for one in commands if one.label == "Notes").act(state)
    draw: Draw = lambda: overlays.draw_notes(state)  # noqa: E731
    for _ in range(3):
        ui.frame(draw)
    ui.io.add_input_characters_utf8("Polyp 1")
    ui.frame(draw)
    assert shown["Notes"]
    assert (state.session.notes, state.session.begins_writing) == ("Polyp 1", False)
    ui.press(draw, imgui.Key.escape)  # It ends typing, and takes nothing back.
    ui.frame(draw)
    assert state.session.notes == "Polyp 1"
    assert not imgui.is_any_item_active()
