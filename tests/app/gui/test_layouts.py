"""The layout of each kind of content: its own from the first, and remembered."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import glfw
import pytest
from imgui_bundle import ImVec2, glfw_utils, hello_imgui, imgui
from imgui_bundle.immapp import testing

from app.gui.actions import actions, arriving, presenting
from app.gui.commands.keys import chord
from app.gui.frame import dockings
from app.gui.state.app_state import AppState
from app.gui.work import kept_layout
from app.gui.work.opening import Opened
from app.gui.work.settings import Places, Settings
from assets import phantom_path
from renderer.gaussians import DynamicGaussians
from tests.app.gui.conftest import make_clip, start_live
from tests.app.gui.driver import Driver, is_settled, wait
from tests.app.gui.test_bare import in_front, shown


def test_the_kind_is_of_what_was_opened(places: Places, model: DynamicGaussians) -> None:
    state, path = AppState(places), places.runs
    assert state.source.content is None
    for clip, kind in (
        (make_clip(path, 1), "stills"),
        (make_clip(path, 6, has_depth=False), "stills"),  # A folder of images.
        (replace(make_clip(path, 6, has_depth=False), format="video"), "clip"),
        (make_clip(path, 6), "clip"),
    ):
        arriving.show_opened(state, path, Opened(clip))
        assert state.source.content == kind
    start_live(state, model)
    assert state.source.content == "clip"  # Panels stay while one works.
    arriving.show_opened(state, path, Opened(None))
    assert state.source.content == "run"


def kept(
    places: Places,
    drive: Callable[[imgui.test_engine.TestContext, AppState], None],
    text_percent: int = 100,
) -> None:
    """A window that keeps its layout, unlike the others of the tests."""
    driver = Driver(places, Settings(acknowledged=True, text_percent=text_percent))

    def and_quit(ctx: imgui.test_engine.TestContext) -> None:
        drive(ctx, driver.state)
        ctx.key_press(chord("Ctrl+Q"))
        ctx.yield_(10)

    params = driver.window.runner_params()
    with pytest.raises(RuntimeError, match="exited before the test finished"):
        testing.run(test_function=and_quit, runner_params=params, add_ons_params=driver.window.add_ons())
    kept_layout.seal(places.config / kept_layout.NAME)


@pytest.mark.display
def test_each_kind_of_content_has_its_layout_and_keeps_it(places: Places, still: Path) -> None:
    widths: dict[str, float] = {}

    def width(ctx: imgui.test_engine.TestContext) -> float:
        ctx.yield_(6)
        return float(ctx.window_info("//Enhancement").window.size.x)

    def show(ctx: imgui.test_engine.TestContext, state: AppState, path: Path, name: str) -> None:
        actions.open_path(state, path)
        wait(ctx, lambda: state.source.path == path and is_settled(state), path.name)
        wait(ctx, lambda: hello_imgui.current_layout_name() == name, "its layout")
        ctx.yield_(6)

    def first(ctx: imgui.test_engine.TestContext, state: AppState) -> None:
        show(ctx, state, still, "Stills")
        assert "Enhancement" in in_front(ctx)
        assert "Reconstruction" not in in_front(ctx)
        widths["Stills"] = width(ctx)
        tabs = imgui.internal.find_window_by_name("Enhancement").dock_node.tab_bar
        beside = widths["Stills"] - (tabs.bar_rect.max.x - tabs.bar_rect.min.x)
        whole = (
            tabs.width_all_tabs_ideal + beside
        )  # This window is narrower than one whose side has all lines.
        assert whole <= dockings.SIDE_OF_TABS * imgui.get_font_size()
        assert whole > dockings.SIDE * imgui.get_font_size()
        show(ctx, state, phantom_path(), "Default")
        assert {"Enhancement", "Reconstruction"} <= in_front(ctx)
        node = imgui.internal.find_window_by_name("Enhancement").dock_node.parent_node
        imgui.internal.dock_builder_set_node_size(node.id_, ImVec2(300, node.size.y))
        dockings.toggle("Notes")
        widths["Default"] = width(ctx)
        assert widths["Default"] != widths["Stills"]
        show(ctx, state, still, "Stills")
        assert width(ctx) == widths["Stills"]
        assert not dockings.is_shown("Notes")
        assert "Enhancement" in in_front(ctx)
        layout = places.config / kept_layout.NAME
        assert layout.is_file()  # What the runner has written meanwhile is sealed, should it end badly.
        wait(ctx, lambda: kept_layout.put_aside_damaged(layout) == "", "the seal")

    def again(ctx: imgui.test_engine.TestContext, state: AppState) -> None:
        show(ctx, state, phantom_path(), "Default")
        assert width(ctx) == widths["Default"]
        assert dockings.is_shown("Notes")
        show(ctx, state, still, "Stills")
        assert width(ctx) == widths["Stills"]
        assert not dockings.is_shown("Notes")

    kept(places, first)
    kept(places, again)


@pytest.mark.display
def test_larger_text_arranges_also_what_only_a_later_session_opens(places: Places, still: Path) -> None:
    """Panels below each other, as they were kept with small text, have no room for large text."""

    def show(ctx: imgui.test_engine.TestContext, state: AppState, path: Path) -> None:
        actions.open_path(state, path)
        wait(ctx, lambda: state.source.path == path and is_settled(state), path.name)
        ctx.yield_(12)

    def first(ctx: imgui.test_engine.TestContext, state: AppState) -> None:
        show(ctx, state, phantom_path())
        assert {"Enhancement", "Reconstruction"} <= in_front(ctx)
        show(ctx, state, still)
        actions.choose_text_size(state, 200)
        ctx.yield_(12)

    def again(ctx: imgui.test_engine.TestContext, state: AppState) -> None:
        show(ctx, state, phantom_path())
        assert hello_imgui.current_layout_name() == "Default"
        assert "Reconstruction" not in in_front(ctx)
        width = ctx.window_info("//Enhancement").window.size.x
        assert width > 0.4 * imgui.get_main_viewport().size.x

    kept(places, first)
    kept(places, again, 200)


@pytest.mark.display
def test_titles_of_panels_are_whole_in_large_text_and_come_into_sight(places: Places) -> None:
    driver = Driver(places, Settings(acknowledged=True, text_percent=200))
    actions.open_path(driver.state, phantom_path())

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: driver.state.source.clip is not None, "the phantom")
        ctx.yield_(12)
        bar = imgui.internal.find_window_by_name("Enhancement").dock_node.tab_bar
        room = bar.bar_rect.max.x - bar.bar_rect.min.x
        assert bar.width_all_tabs_ideal > room
        assert all(tab.width >= tab.content_width for tab in bar.tabs)
        for name in ("Cameras", "Enhancement"):
            ctx.window_focus(f"//{name}")
            ctx.yield_(30)
            assert name in in_front(ctx)
            (tab,) = (tab for tab in bar.tabs if tab.id_ == bar.selected_tab_id)
            left = tab.offset - bar.scrolling_anim
            assert -1 <= left <= left + tab.width <= room + 1, name

    driver.run(drive)


@pytest.mark.display
def test_another_layout_waits_until_all_panels_are_there(places: Places, still: Path) -> None:
    driver = Driver(places, opens=phantom_path())
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        ctx.key_press(imgui.Key.tab)
        ctx.yield_(3)
        actions.open_path(state, still)
        wait(ctx, lambda: state.source.content == "stills", "the still")
        ctx.yield_(4)
        assert hello_imgui.current_layout_name() == "Default"
        assert in_front(ctx) == {"Images"}
        ctx.key_press(imgui.Key.tab)
        ctx.yield_(6)
        assert hello_imgui.current_layout_name() == "Stills"
        assert in_front(ctx) == {"Images", "Enhancement"}
        before = shown()
        actions.open_path(state, phantom_path())
        wait(ctx, lambda: hello_imgui.current_layout_name() == "Default", "the clip")
        ctx.yield_(6)
        assert shown() == before
        assert in_front(ctx) == {"Images", "Enhancement", "Reconstruction"}

    driver.run(drive)


@pytest.mark.display
def test_what_is_below_keeps_its_share_when_the_window_grows_before_and_while_it_is_shown(
    places: Places, model: DynamicGaussians
) -> None:
    driver = Driver(places, opens=phantom_path())
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        def share() -> float:
            view, pictures = (ctx.window_info(f"//{name}").window.size.y for name in ("3D view", "Images"))
            return float(view / (view + pictures))

        def grow(height: int) -> None:
            glfw.set_window_size(glfw_utils.glfw_window_hello_imgui(), 1280, height)
            wait(ctx, lambda: imgui.get_main_viewport().size.y == height, "the size")
            ctx.yield_(4)

        wait(ctx, lambda: is_settled(state), "the phantom")
        grow(1000)
        start_live(state, model)
        wait(ctx, lambda: state.scene.view is not None, "the 3D view")
        ctx.yield_(4)
        first = share()
        assert first == pytest.approx(0.52, abs=0.02)
        grow(720)
        assert share() == pytest.approx(first, abs=0.01)
        node = imgui.internal.find_window_by_name("3D view").dock_node
        imgui.internal.dock_builder_set_node_size(node.id_, ImVec2(node.size.x, 0.7 * node.size.y))
        ctx.yield_(4)
        smaller = share()
        assert smaller < first - 0.1
        grow(1000)
        assert share() == pytest.approx(smaller, abs=0.01)
        state.window.closing = "agreed"

    driver.run(drive)


@pytest.mark.display
def test_in_an_upright_window_panels_are_below_the_images(
    places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    driver = Driver(places, opens=phantom_path())
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        def shape(width: int, height: int) -> None:
            glfw.set_window_size(glfw_utils.glfw_window_hello_imgui(), width, height)
            wait(ctx, lambda: imgui.get_main_viewport().size.y == height, "the size")
            ctx.yield_(6)

        def is_below(lower: str, upper: str) -> bool:
            below, above = (ctx.window_info(f"//{name}").window for name in (lower, upper))
            return bool(below.pos.y >= above.pos.y + above.size.y)

        wait(ctx, lambda: is_settled(state), "the phantom")
        shape(720, 1000)
        images, side = (ctx.window_info(f"//{name}").window for name in ("Images", "Enhancement"))
        assert images.size.x == imgui.get_main_viewport().size.x
        assert is_below("Enhancement", "Images")
        assert is_below("Reconstruction", "Images")
        assert not is_below("Reconstruction", "Enhancement")
        assert images.size.y > side.size.y
        with monkeypatch.context() as patch:
            resets = list[str]()
            patch.setattr(dockings, "restore_all", lambda: resets.append("all panels"))
            presenting.toggle(state)
            ctx.yield_(6)
            presenting.toggle(state)
            ctx.yield_(6)
            before = side.size.y
            ctx.key_press(chord("Ctrl+minus"))  # To 90 %.
            ctx.yield_(6)
            assert side.size.y == pytest.approx(0.9 * before, rel=0.03)
        assert resets == []
        assert is_below("Enhancement", "Images")
        shape(1280, 720)
        assert not is_below("Enhancement", "Images")
        assert is_below("Reconstruction", "Enhancement")
        state.window.closing = "agreed"

    driver.run(drive)


@pytest.mark.display
def test_ctrl_r_shows_where_depth_is_chosen(places: Places, still: Path) -> None:
    """Of stills the panel is behind the enhancement."""
    driver = Driver(places)
    actions.open_path(driver.state, still)

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(driver.state), "the image")
        ctx.yield_(6)
        assert in_front(ctx) == {"Images", "Enhancement"}
        ctx.key_press(chord("Ctrl+R"))
        ctx.yield_(4)
        assert in_front(ctx) == {"Images", "Reconstruction"}

    driver.run(drive)
