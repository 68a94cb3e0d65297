"""One pane alone: which, what its keys do, what it says, and that all is as before afterwards."""

from __future__ import annotations

from typing import Any

import glfw
import numpy as np
import pytest
from imgui_bundle import ImVec2, glfw_utils, hello_imgui, imgui

from app.gui.actions import actions, enhancement_actions, floating_windows, presenting, tuning_actions
from app.gui.commands.keys import chord
from app.gui.frame import starting
from app.gui.frame.window_shots import read_window
from app.gui.panels import picture_pane, presentation
from app.gui.panels.presentation import draw_presentation
from app.gui.state.app_state import AppState
from app.gui.style import labels, theme
from app.gui.style.widgets import Area
from app.gui.views.resample import visible
from app.gui.work.settings import Places, Settings
from assets import phantom_path
from enhance import EnhanceParams
from renderer.clip import ByteImage
from renderer.gaussians import DynamicGaussians
from tests.app.gui.conftest import start_live
from tests.app.gui.driver import Driver, enhanced, is_settled, wait
from tests.app.gui.test_bare import in_front, shown
from tests.app.gui.test_keys import keyboard
from tests.app.gui.test_masking import begun, stroke
from tests.app.gui.ui import Draw, Shown, StillViewport, Ui, compare, pictures


def presented(state: AppState, shown: Shown, first: Shown | None = None) -> Draw:
    """A frame of the presentation and the keys behind it; `first` stands for textures of the first."""
    keys = keyboard(state)

    def draw() -> None:
        draw_presentation(state, first or shown, shown, StillViewport())
        keys()

    return draw


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """All labels that are drawn over a pane."""
    texts: list[str] = []
    tag = labels.tag

    def seen(text: str, *rest: object) -> float:
        texts.append(text)
        return tag(text, *rest)  # type: ignore[arg-type]

    for module in ("app.gui.style.labels", "app.gui.panels.picture_pane", "app.gui.panels.presentation"):
        monkeypatch.setattr(f"{module}.tag", seen)
    return texts


def test_f5_presents_the_pane_under_the_pointer_or_the_one_clicked_last(ui: Ui, opened: AppState) -> None:
    keys, panes = keyboard(opened), compare(opened, Shown())

    def draw() -> None:
        presenting.begin_frame(opened)
        panes()
        keys()

    for at, pane in (((200, 400), "left"), ((700, 400), "right")):
        ui.drag(draw, at, at)
        ui.press(draw, imgui.Key.f5)
        assert opened.presenting.pane == pane
        ui.press(draw, imgui.Key.f5)
        assert opened.presenting.pane is None
    ui.drag(draw, (200, 400), (200, 400))
    ui.io.add_mouse_pos_event(890, 5)
    ui.frame(draw)
    ui.press(draw, imgui.Key.f5)
    assert opened.presenting.pane == "left"


def test_windows_that_lie_over_the_panes_are_closed_for_it(opened: AppState) -> None:
    floating: tuple[floating_windows.Floating, ...] = (
        opened.exports, opened.summary, opened.batches, opened.guide, opened.about, opened.live.choice
    )  # fmt: skip
    for window in floating:
        floating_windows.show(window, True)
    opened.window.help_open = True
    presenting.show(opened, "right")
    assert not any(window.shown for window in floating)
    assert not opened.window.help_open
    floating_windows.toggle(opened.guide)
    presenting.step(opened, 1)
    assert opened.guide.shown


def test_the_first_image_lies_over_what_is_left_of_the_panels(ui: Ui, opened: AppState) -> None:
    first, behind = Shown(), Shown()
    draw = presented(opened, behind, first)
    presenting.show(opened, "right")
    ui.frame(draw)
    assert (list(first.images), list(behind.images)) == (["right"], [])
    first.images.clear()
    ui.frame(draw)
    assert (list(first.images), list(behind.images)) == ([], ["right"])


def test_f5_takes_no_pane_that_is_behind_another_panel(
    ui: Ui, opened: AppState, model: DynamicGaussians
) -> None:
    keys, panes = keyboard(opened), compare(opened, Shown())
    start_live(opened, model)
    presenting.point(opened, "3D view", clicked=True)

    def draw() -> None:
        presenting.begin_frame(opened)
        panes()
        keys()

    ui.io.add_mouse_pos_event(890, 5)
    ui.frame(draw)
    ui.press(draw, imgui.Key.f5)
    assert opened.presenting.pane == "left"


def test_keys_of_a_presentation(ui: Ui, opened: AppState, model: DynamicGaussians) -> None:
    draw, key = presented(opened, Shown()), imgui.Key
    ui.press(draw, key.f5)
    assert (opened.presenting.pane, opened.window.full_screen) == ("right", True)
    ui.press(draw, key._3)  # There is no model.
    assert opened.presenting.pane == "right"
    start_live(opened, model)
    panes = []
    for press in (key._1, key._3, key._2, key.down_arrow, key.down_arrow, key.up_arrow):
        ui.press(draw, press)
        panes.append(opened.presenting.pane)
    assert panes == ["left", "3D view", "right", "3D view", "left", "3D view"]
    assert opened.picture.view.zoom is None  # 1 is 1:1 elsewhere.
    ui.press(draw, key.right_arrow)
    assert opened.timeline.frame_index == 1
    ui.press(draw, key.space)
    assert opened.timeline.playing
    ui.press(draw, key.escape)
    assert (opened.presenting.pane, opened.window.full_screen) == (None, False)


def test_ctrl_z_undoes_the_stroke_while_tools_are_masked_in_a_presentation(ui: Ui, opened: AppState) -> None:
    begun(opened)
    enhancement_actions.settle_params(opened)
    enhancement_actions.set_params(opened, EnhanceParams(z=0.2))
    enhancement_actions.settle_params(opened)
    draw, key = presented(opened, Shown()), imgui.Key
    ui.press(draw, key.f5)
    stroke(opened, (10.0, 20.0))
    ui.press(draw, key.mod_ctrl, key.z)
    assert opened.masking.past == ()
    assert opened.enhancement.params == EnhanceParams(z=0.2)
    ui.press(draw, key._1)
    assert opened.presenting.pane == "left"


def test_the_original_is_there_while_o_is_held(ui: Ui, opened: AppState) -> None:
    shown = Shown()
    draw = presented(opened, shown)
    ui.press(draw, imgui.Key.f5)
    ui.frame(draw)
    assert shown.images["right"] is pictures(opened).enhanced
    ui.io.add_key_event(imgui.Key.o, True)
    ui.frame(draw)
    ui.frame(draw)
    assert shown.images["right"] is pictures(opened).original
    ui.io.add_key_event(imgui.Key.o, False)
    ui.frame(draw)
    ui.frame(draw)
    assert shown.images["right"] is pictures(opened).enhanced


def test_labels_come_for_a_moment_and_on_demand(ui: Ui, opened: AppState, said: list[str]) -> None:
    draw = presented(opened, Shown())

    def labels() -> str:
        said.clear()
        ui.frame(draw)
        return " | ".join(said)

    ui.press(draw, imgui.Key.f5)
    at_first = labels()
    for part in ("ENHANCED", "1 / 6", "Research use only", "Esc: leave"):
        assert part in at_first
    opened.window.now += presenting.LABELS_SECONDS - 0.1
    assert labels() == at_first
    opened.window.now += 0.2
    assert labels() == ""
    actions.toggle_freeze(opened)  # What could mislead is always said.
    assert labels() == "FROZEN · frame 1"
    ui.press(draw, imgui.Key.l)
    assert "ENHANCED" in labels()
    assert "Research use only" in labels()
    assert "Esc: leave" not in labels()
    ui.press(draw, imgui.Key.l)
    assert "ENHANCED" not in labels()


def test_the_hint_lies_below_the_image_which_stays_where_it_is(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    tops: list[float] = []
    panes: list[Area] = []
    tag, pane = labels.tag, picture_pane.draw_pane

    def draw_pane(*given: Any, **more: Any) -> Any:
        panes.append(given[5])
        return pane(*given, **more)

    def draw_tag(text: str, at: ImVec2, *rest: Any) -> float:
        tops.append(at.y)
        return tag(text, at, *rest)

    monkeypatch.setattr(presentation, "tag", draw_tag)
    monkeypatch.setattr(presentation, "draw_pane", draw_pane)
    draw = presented(opened, Shown())
    ui.press(draw, imgui.Key.f5)
    ui.frame(draw)
    assert len(tops) == len(panes) > 0
    assert all(top >= one.end.y for top, one in zip(tops, panes, strict=True))
    opened.window.now += 2 * presenting.LABELS_SECONDS
    ui.frame(draw)
    assert len(tops) < len(panes)
    assert len({(*one.corner, *one.size) for one in panes}) == 1


def test_it_ends_with_what_it_shows(opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    presenting.show(opened, "3D view")
    opened.scene.model = None
    presenting.follow(opened)
    assert opened.presenting.pane == "right"
    opened.picture.pictures = None
    presenting.follow(opened)
    assert (opened.presenting.pane, opened.window.full_screen) == (None, False)


@pytest.mark.display
def test_the_image_is_on_the_screen_pixel_for_pixel(places: Places) -> None:
    """It is drawn behind the panels; what is beside it is dark, in the light theme as well."""
    driver = Driver(places, Settings(acknowledged=True, theme="light"), opens=phantom_path())
    state, screens = driver.state, list[ByteImage]()

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        presenting.show(state, "right")
        wait(ctx, lambda: state.window.now > state.presenting.labels_until, "the labels to go")
        calls = hello_imgui.get_runner_params().callbacks
        calls.before_swap = lambda: screens.append(read_window(starting.attach()))
        ctx.yield_(2)
        area, image = ctx.item_info("//##presentation/right").rect_full, enhanced(state)
        pane = area.max.x - area.min.x, area.max.y - area.min.y
        patch = visible(image, state.picture.view.place((image.shape[1], image.shape[0]), pane), pane)
        assert patch is not None
        height, width = patch.pixels.shape[:2]
        shown = screens[-1][patch.y : patch.y + height, patch.x : patch.x + width]
        assert screens[-1][:, -3].max() <= round(255 * theme.SURROUND.x)
        # Two notes lie in corners.
        np.testing.assert_array_equal(
            shown[height // 4 : -height // 4], patch.pixels[height // 4 : -height // 4]
        )
        panel: imgui.internal.Window | None = imgui.internal.find_window_by_name("##presentation")
        assert panel is not None
        # That of the letters.
        assert len({command.get_tex_id() for command in panel.draw_list.cmd_buffer}) == 1

    driver.run(drive)


@pytest.mark.display
def test_the_whole_window_is_the_pane_and_then_as_before(places: Places) -> None:
    driver = Driver(places, opens=phantom_path())
    state, key = driver.state, imgui.Key

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        def is_there(name: str) -> bool:
            found: imgui.internal.Window | None = imgui.internal.find_window_by_name(name)
            return found is not None and found.active

        wait(ctx, lambda: is_settled(state), "the phantom")
        tuning_actions.toggle_tuning(state)
        ctx.yield_(4)
        window = glfw_utils.glfw_window_hello_imgui()
        size, front, panels = glfw.get_window_size(window), in_front(ctx), shown()
        width = ctx.window_info("//Tuning").window.size.x
        assert "Tuning" in front
        ctx.key_press(key.f5)
        wait(ctx, lambda: bool(glfw.get_window_monitor(window)), "the screen")
        ctx.yield_(4)
        assert shown() == set()
        assert not any(map(is_there, ("##MainMenuBar", "StatusBar", "Images")))
        assert hello_imgui.get_runner_params().callbacks.edges_toolbars == {}
        docking = hello_imgui.get_runner_params().docking_params
        behind = imgui.internal.dock_builder_get_node(docking.dock_space_id_from_name(presentation.HOST))
        drawn = behind.host_window.draw_list
        assert drawn.vtx_buffer.size() == 0  # No ground below what covers it all.
        screen = imgui.get_main_viewport().size
        pane = ctx.item_info("//##presentation/right")
        assert (pane.rect_full.min.x, pane.rect_full.min.y, pane.rect_full.max.x) == (0, 0, screen.x)
        below = screen.y - pane.rect_full.max.y
        assert imgui.get_font_size() < below < 2.2 * imgui.get_font_size()  # A line for the hint.
        ctx.item_click("//##presentation/right")  # It stays behind what opens over it.
        ctx.key_press(chord("Ctrl+Shift+P"))
        ctx.yield_(3)
        assert state.window.palette.shown
        assert imgui.get_style().color_(imgui.Col_.window_bg).w == 1
        ctx.key_press(key.escape)
        ctx.yield_(3)
        ctx.key_press(key.escape)
        wait(ctx, lambda: glfw.get_window_size(window) == size, "the window")
        ctx.yield_(6)
        assert imgui.get_style().color_(imgui.Col_.docking_empty_bg).w == 1
        assert state.presenting.pane is None
        assert (shown(), in_front(ctx)) == (panels, front)
        assert ctx.window_info("//Tuning").window.size.x == width
        assert all(map(is_there, ("##MainMenuBar", "StatusBar")))
        assert len(hello_imgui.get_runner_params().callbacks.edges_toolbars) == 1

    driver.run(drive)


@pytest.mark.display
def test_no_frame_is_dark_when_it_ends(places: Places) -> None:
    driver = Driver(places, opens=phantom_path())
    state, screens = driver.state, list[ByteImage]()

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        presenting.show(state, "right")
        ctx.yield_(6)
        calls = hello_imgui.get_runner_params().callbacks
        calls.before_swap = lambda: screens.append(read_window(starting.attach()))
        presenting.leave(state)
        ctx.yield_(8)
        lit = [float(screen[: screen.shape[0] // 2].mean()) for screen in screens]
        assert min(lit) > 0.7 * lit[-1]
        assert state.presenting.ending is None

    driver.run(drive)


@pytest.mark.display
def test_it_ends_in_a_window_without_panels_too(places: Places) -> None:
    driver = Driver(places, opens=phantom_path())
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        state.window.bare = True
        ctx.yield_(6)
        presenting.show(state, "right")
        ctx.yield_(6)
        presenting.leave(state)
        ctx.yield_(6)
        assert state.presenting.ending is None
        state.window.closing = "agreed"

    driver.run(drive)
