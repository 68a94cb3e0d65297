"""The pictures alone, and the whole screen, in the real window."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import glfw
import pytest
from imgui_bundle import glfw_utils, hello_imgui, imgui
from imgui_bundle.immapp import testing

from app.gui.actions import actions, session_actions
from app.gui.frame import dockings
from app.gui.style import theme
from app.gui.work import kept_layout
from app.gui.work.settings import Places
from assets import phantom_path
from tests.app.gui.driver import Driver, is_settled, wait


def shown() -> set[str]:
    """Panels that are in sight or behind another one's tab."""
    panels = hello_imgui.get_runner_params().docking_params.dockable_windows
    return {panel.label for panel in panels if panel.is_visible}


def in_front(ctx: imgui.test_engine.TestContext) -> set[str]:
    """Of these, the ones not behind another one's tab."""
    return {name for name in shown() if not ctx.window_info(f"//{name}").window.hidden}


@pytest.mark.display
def test_tab_leaves_the_pictures_alone_and_brings_all_panels_back(places: Places) -> None:
    driver = Driver(places, opens=phantom_path())
    state, key = driver.state, imgui.Key

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        def width() -> float:
            return float(ctx.window_info("//Images").window.size.x)

        wait(ctx, lambda: is_settled(state), "the phantom")
        before, narrow, front = shown(), width(), in_front(ctx)
        assert "Reconstruction" in front
        # What its place shows for a frame when it is hidden.
        node = ctx.window_info("//Reconstruction").window.dock_node
        assert node.last_bg_color == imgui.get_color_u32(theme.now().ground)
        ctx.item_click("//Images/**/###freeze")  # Whatever has the focus.
        ctx.key_press(key.tab)
        ctx.yield_(4)
        assert shown() == {"Images"}
        assert width() == imgui.get_main_viewport().size.x > narrow
        ctx.key_press(key.tab)
        ctx.yield_(4)
        assert (shown(), width()) == (before, narrow)
        assert in_front(ctx) == front
        ctx.key_press(key.tab)
        ctx.yield_(2)
        ctx.key_press(key.escape)
        ctx.yield_(4)
        assert shown() == before
        ctx.key_press(key.tab)
        ctx.yield_(2)
        state.tuning.shown = False
        ctx.key_press(key.mod_ctrl | key.t)  # What is asked for is there.
        ctx.yield_(4)
        assert shown() == before | {"Tuning"}
        assert "Tuning" in in_front(ctx)

    driver.run(drive)


@pytest.mark.display
def test_tuning_comes_back_behind_the_images_where_it_was(places: Places, tmp_path: Path) -> None:
    driver = Driver(places, opens=phantom_path())
    state, key, session = driver.state, imgui.Key, tmp_path / "monday.vesselsplat"

    def tuning_is(ctx: imgui.test_engine.TestContext) -> str:
        ctx.yield_(6)
        return "in front" if "Tuning" in in_front(ctx) else "behind" if "Tuning" in shown() else "away"

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        ctx.key_press(key.mod_ctrl | key.t)
        assert tuning_is(ctx) == "in front"
        ctx.key_press(key.tab)
        assert tuning_is(ctx) == "away"
        ctx.key_press(key.tab)
        assert tuning_is(ctx) == "in front"
        ctx.window_focus("//Images")
        assert tuning_is(ctx) == "behind"
        ctx.key_press(key.tab)
        assert tuning_is(ctx) == "away"
        ctx.key_press(key.escape)
        assert tuning_is(ctx) == "behind"
        session_actions.save_to(state, session)
        wait(ctx, session.is_file, "the session")
        ctx.key_press(key.mod_ctrl | key.t)
        assert tuning_is(ctx) == "away"
        state.session.path = None  # Its file stays as it is.
        actions.open_path(state, session)
        wait(ctx, lambda: state.session.path == session and is_settled(state), "the session")
        assert tuning_is(ctx) == "behind"

    driver.run(drive)


@pytest.mark.display
def test_f11_fills_the_screen_and_goes_back_to_its_place(places: Places) -> None:
    driver = Driver(places)

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        window = glfw_utils.glfw_window_hello_imgui()
        screen = glfw.get_video_mode(glfw.get_primary_monitor()).size
        place = (*glfw.get_window_pos(window), *glfw.get_window_size(window))

        def is_over(size: tuple[int, int]) -> Callable[[], bool]:
            return lambda: tuple(glfw.get_window_size(window)) == size

        ctx.key_press(imgui.Key.f11)
        wait(ctx, lambda: bool(glfw.get_window_monitor(window)), "the screen")
        wait(ctx, is_over((screen.width, screen.height)), "its size")
        ctx.key_press(imgui.Key.escape)
        wait(ctx, lambda: not glfw.get_window_monitor(window), "the window")
        wait(ctx, is_over(place[2:]), "its size")
        assert driver.state.enhancement.active

    driver.run(drive)


@pytest.mark.display
def test_a_window_that_ends_so_is_kept_with_its_panels_and_in_its_place(places: Places) -> None:
    driver = Driver(places)
    size: list[tuple[int, int]] = []

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        size.append(dockings.window_size(first=False))
        dockings.toggle("Notes")
        ctx.yield_(3)
        ctx.key_press(imgui.Key.tab)
        ctx.key_press(imgui.Key.f11)
        ctx.yield_(4)
        assert driver.state.window.full_screen
        assert "Notes" not in shown()
        ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.q)
        ctx.yield_(10)

    params = driver.window.runner_params()
    with pytest.raises(RuntimeError, match="exited before the test finished"):  # By Ctrl+Q.
        testing.run(test_function=drive, runner_params=params, add_ons_params=driver.window.add_ons())
    kept = (places.config / kept_layout.NAME).read_text()
    assert "_Notes=true" in kept
    assert f"WindowSize={size[0][0]},{size[0][1]}" in kept
