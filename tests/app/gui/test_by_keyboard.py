"""The whole window by keyboard: every panel, menus and timeline, each of their controls."""

from __future__ import annotations

import pytest
from imgui_bundle import imgui

from app.gui.actions import actions, enhancement_actions
from app.gui.commands.keys import chord
from app.gui.work.settings import Places
from assets import phantom_path
from enhance import EnhanceParams
from tests.app.gui.driver import Driver, is_settled, wait

Context = imgui.test_engine.TestContext
K = imgui.Key


def root() -> str:
    window: imgui.internal.Window | None = imgui.get_current_context().nav_window
    return "" if window is None else str(window.root_window.name)


def press(ctx: Context, *keys: int) -> None:
    for key in keys:
        ctx.key_press(key)
        ctx.yield_()


def visited(ctx: Context) -> set[int]:
    """All controls that Tab leads to in a panel, until it is where it began."""
    found: set[int] = set()
    for _ in range(80):
        press(ctx, K.tab)
        now = int(imgui.get_current_context().nav_id)
        if now in found:
            break
        found.add(now)
    return found


@pytest.mark.display
def test_every_panel_and_control_is_reached(places: Places) -> None:
    driver = Driver(places)
    state = driver.state
    enhancement_actions.set_params(state, EnhanceParams())
    actions.open_path(state, phantom_path())

    def drive(ctx: Context) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        names = ("strength", "z", "p", "d_factor")
        sliders = {name: ctx.item_info(f"//Enhancement/**/##{name}").id_ for name in names}
        press(ctx, chord("Shift+Tab"))
        assert imgui.get_io().nav_visible
        first, panels, reached = root(), list[str](), dict[str, set[int]]()
        for _ in range(12):
            panels.append(root())
            assert imgui.get_io().nav_visible, panels
            if not root().startswith("##MainMenu"):
                reached[root()] = visited(ctx)
            press(ctx, K.f6)
            if root() == first:
                break
        assert {"Images", "Enhancement", "Reconstruction", "##MainMenuBar"} <= set(panels)
        assert any(name.startswith("##Bottom") for name in panels)
        press(ctx, chord("Shift+F6"))
        assert root() == panels[-1]
        for panel, lists in (("Enhancement", ("Method", "preset")), ("Images", ("left", "right", "mode"))):
            for name in lists:
                item = imgui.internal.find_window_by_name(panel).get_id(f"##{name}")
                assert item in reached[panel], f"{panel}: {name}"
        for name, item in sliders.items():
            assert item in reached["Enhancement"], name

    driver.run(drive)


@pytest.mark.display
def test_a_slider_a_list_a_menu_and_the_timeline_by_keys_alone(places: Places) -> None:
    driver = Driver(places)
    state = driver.state
    enhancement_actions.set_params(state, EnhanceParams())
    actions.open_path(state, phantom_path())

    def to(ctx: Context, panel: str) -> None:
        for _ in range(12):
            press(ctx, K.f6)
            if root().startswith(panel):
                return
        raise AssertionError(f"no {panel}")

    def on(ctx: Context, item: int) -> None:
        for _ in range(80):
            if imgui.get_current_context().nav_id == item:
                return
            press(ctx, K.tab)
        raise AssertionError("not reached")

    def drive(ctx: Context) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        to(ctx, "Enhancement")
        on(ctx, ctx.item_info("//Enhancement/**/##strength").id_)
        ctx.key_chars_replace("1.5")  # Tab leads into a number as into a field.
        press(ctx, K.enter)
        assert state.enhancement.params.strength == 1.5
        press(ctx, K.space, K.right_arrow, K.right_arrow, K.space)
        assert state.enhancement.params.strength > 1.5
        assert state.timeline.frame_index == 0
        to(ctx, "##Bottom")
        on(ctx, ctx.item_info("//**/##frame").id_)
        ctx.key_chars_replace("3")
        press(ctx, K.enter)
        assert state.timeline.frame_index == 2
        to(ctx, "##MainMenuBar")
        press(ctx, K.right_arrow, K.enter)  # Image
        ctx.yield_(3)
        press(ctx, K.enter)  # Its first entry: enhancement on or off.
        assert not state.enhancement.active
        press(ctx, K.escape, K.escape)
        assert not imgui.get_io().nav_visible
        press(ctx, K.right_arrow)
        assert state.timeline.frame_index == 3

    driver.run(drive)
