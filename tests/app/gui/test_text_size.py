"""Larger and smaller text: the side, the panels, the menus and the notice keep their room."""

from __future__ import annotations

from collections.abc import Callable

import glfw
import pytest
from imgui_bundle import ImVec2, ImVec4, glfw_utils, imgui

from app.files.provenance import NOTICE
from app.gui.actions import actions
from app.gui.commands.keys import chord
from app.gui.frame import dockings
from app.gui.frame.dockings import MOST
from app.gui.panels.overlays import LONG_NOTICE
from app.gui.work.settings import TEXT_PERCENTS, Places, Settings
from tests.app.gui.driver import Driver, wait


@pytest.mark.display
def test_the_side_grows_with_the_text_and_shrinks_back(places: Places) -> None:
    driver = Driver(places)
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        def width() -> float:
            ctx.yield_(4)
            return float(ctx.window_info("//Enhancement").window.size.x)

        first = width()
        for _ in range(3):
            ctx.key_press(chord("Ctrl+plus"))
        assert state.settings.text_percent == 150
        most = MOST * imgui.get_main_viewport().size.x
        assert width() == pytest.approx(min(1.5 * first, most), rel=0.02)
        ctx.key_press(chord("Ctrl+0"))
        assert width() == pytest.approx(first, rel=0.02)

    driver.run(drive)


@pytest.mark.display
def test_a_pane_cannot_be_dragged_until_nothing_of_it_is_seen(places: Places) -> None:
    driver = Driver(places)

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        ctx.yield_(4)
        side, screen = ctx.window_info("//Enhancement").window, imgui.get_main_viewport().size
        for x in (screen.x - 2, 2):
            ctx.mouse_move_to_pos(ImVec2(side.pos.x - 2, side.pos.y + 60))
            ctx.mouse_down()
            ctx.mouse_move_to_pos(ImVec2(x, side.pos.y + 60))
            ctx.mouse_up()
            ctx.yield_(4)
            side = ctx.window_info("//Enhancement").window
            assert 200 <= side.size.x <= screen.x - 200

    driver.run(drive)


@pytest.mark.display
def test_the_side_is_as_wide_as_before_where_it_had_no_room_to_grow(places: Places) -> None:
    driver = Driver(places)
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        glfw.set_window_size(glfw_utils.glfw_window_hello_imgui(), 640, 400)
        wait(ctx, lambda: imgui.get_main_viewport().size.x == 640, "the small window")
        dockings.restore_all()
        ctx.yield_(6)
        first = ctx.window_info("//Enhancement").window.size.x
        for _ in range(len(TEXT_PERCENTS)):
            ctx.key_press(chord("Ctrl+plus"))
        assert state.settings.text_percent == TEXT_PERCENTS[-1]
        ctx.key_press(chord("Ctrl+0"))
        ctx.yield_(4)
        assert ctx.window_info("//Enhancement").window.size.x == pytest.approx(first, rel=0.1)

    driver.run(drive)


@pytest.mark.display
def test_text_made_smaller_leaves_the_titles_of_tabs_at_the_side_whole(places: Places) -> None:
    driver = Driver(places, Settings(acknowledged=True, text_percent=200))

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        def width() -> float:
            ctx.yield_(6)
            return float(ctx.window_info("//Enhancement").window.size.x)

        glfw.set_window_size(glfw_utils.glfw_window_hello_imgui(), 1280, 720)
        wait(ctx, lambda: imgui.get_main_viewport().size.x == 1280, "the low window")
        dockings.restore_all()
        assert width() == pytest.approx(MOST * 1280, rel=0.01)
        for _ in range(2):
            ctx.key_press(chord("Ctrl+minus"))
        assert driver.state.settings.text_percent == 150
        shrunk = width()
        dockings.restore_all()
        assert shrunk == pytest.approx(width(), rel=0.01)

    driver.run(drive)


@pytest.mark.display
def test_panels_share_a_place_where_lines_are_few(places: Places) -> None:
    driver = Driver(places)

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        def share_a_place() -> bool:
            ctx.yield_(6)
            places = [
                ctx.window_info(f"//{name}").window.dock_id for name in ("Enhancement", "Reconstruction")
            ]
            return places[0] == places[1]

        assert not share_a_place()
        for _ in range(4):
            ctx.key_press(chord("Ctrl+plus"))
        assert driver.state.settings.text_percent == 175
        assert share_a_place()
        ctx.key_press(chord("Ctrl+0"))
        assert not share_a_place()

    driver.run(drive)


@pytest.mark.display
def test_with_large_text_every_menu_and_the_whole_notice_are_within_a_narrow_window(
    places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    driver = Driver(places, Settings(acknowledged=True, text_percent=200))
    state, ends = driver.state, dict[str, float]()

    def remembered(draw: Callable[..., None]) -> Callable[..., None]:
        def drawn(color: ImVec4, text: str) -> None:
            draw(color, text)
            ends[text] = imgui.get_item_rect_max().x

        return drawn

    monkeypatch.setattr(imgui, "text_colored", remembered(imgui.text_colored))

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        glfw.set_window_size(glfw_utils.glfw_window_hello_imgui(), 640, 900)
        wait(ctx, lambda: imgui.get_main_viewport().size.x == 640, "the narrow window")
        ends.clear()
        ctx.yield_(4)
        assert ends[NOTICE] <= 640
        assert LONG_NOTICE not in ends
        bar = "//##MainMenuBar/##MenuBar"
        assert ctx.item_info(f"{bar}/More").rect_full.max.x <= 640
        ctx.item_click(f"{bar}/More")
        assert ctx.item_exists("//###Menu_00/Help")
        ctx.key_press(imgui.Key.escape)
        actions.choose_text_size(state, 80)
        ctx.yield_(4)
        assert ends[LONG_NOTICE] <= 640
        assert ctx.item_exists(f"{bar}/Help")
        assert not ctx.item_exists(f"{bar}/More")

    driver.run(drive)
