"""The second window: its pixels, what it follows, and how it comes and goes."""

from __future__ import annotations

from dataclasses import replace

import glfw
import numpy as np
import pytest
from imgui_bundle import imgui

from app.gui.actions import actions, presenting
from app.gui.commands.keys import chord
from app.gui.drawing.label_image import label_image
from app.gui.drawing.quads import Quad, QuadView
from app.gui.frame import second_window
from app.gui.state.tags import Tag
from app.gui.views.picture_view import PictureView
from app.gui.views.resample import visible
from app.gui.work.settings import Places, load_settings
from assets import phantom_path
from renderer.clip import ByteImage
from tests.app.gui.driver import Driver, enhanced, is_settled, wait

SIZE = second_window.SIZE


class Seen:
    """What a second window has shown, read from it as soon as it is drawn."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.images: list[ByteImage] = []
        self.windows: list[object] = []
        draw, create = QuadView.draw, glfw.create_window

        def drawn(view: QuadView, quads: tuple[Quad, ...], size: tuple[int, int]) -> None:
            draw(view, quads, size)
            content = view._ctx.detect_framebuffer(0).read(viewport=(0, 0, *size), components=3, alignment=1)
            self.images.append(np.frombuffer(content, np.uint8).reshape(size[1], size[0], 3)[::-1])

        def created(*given: object) -> object:
            self.windows.append(create(*given))
            return self.windows[-1]

        monkeypatch.setattr(QuadView, "draw", drawn)
        monkeypatch.setattr(glfw, "create_window", created)

    def shows(self, image: ByteImage) -> bool:
        """As large as it fits, black around it."""
        if not self.images:
            return False
        place = PictureView().place((image.shape[1], image.shape[0]), SIZE)
        patch, expected = visible(image, place, SIZE), np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
        assert patch is not None
        height, width = patch.pixels.shape[:2]
        assert height == SIZE[1] or width == SIZE[0]
        expected[patch.y : patch.y + height, patch.x : patch.x + width] = patch.pixels
        return np.array_equal(self.images[-1], expected)


@pytest.fixture
def seen(monkeypatch: pytest.MonkeyPatch) -> Seen:
    return Seen(monkeypatch)


@pytest.fixture
def driver(places: Places) -> Driver:
    made = Driver(places)
    actions.open_path(made.state, phantom_path())
    made.state.second_window.labels = False
    return made


@pytest.mark.display
def test_it_shows_the_enhanced_frame_follows_and_closes_twice(driver: Driver, seen: Seen) -> None:
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        for way in ("its X", "the menu"):
            ctx.key_press(chord("Shift+F5"))
            wait(ctx, lambda: seen.shows(enhanced(state)), "the enhanced frame")
            before = seen.images[-1]
            ctx.key_press(imgui.Key.right_arrow)
            wait(ctx, lambda: is_settled(state) and seen.shows(enhanced(state)), "the next frame")
            assert not np.array_equal(before, seen.images[-1])
            if way == "its X":
                glfw.set_window_should_close(seen.windows[-1], True)  # type: ignore[arg-type]
            else:
                ctx.set_ref("##MainMenuBar")
                ctx.menu_click("View/Second window")
                ctx.set_ref("")
            wait(ctx, lambda: not state.second_window.shown, "its end")
            ctx.yield_(3)
            seen.images.clear()
        assert len(seen.windows) == 2
        assert state.timeline.frame_index == 2
        assert state.window.banner is None

    driver.run(drive)


@pytest.mark.display
def test_nothing_is_drawn_while_nothing_changes(driver: Driver, seen: Seen) -> None:
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        presenting.toggle_second(state)
        wait(ctx, lambda: seen.shows(enhanced(state)), "the enhanced frame")
        ctx.yield_(10)  # The system may say that it was covered.
        drawn = len(seen.images)
        ctx.yield_(30)
        assert len(seen.images) == drawn
        state.second_window.labels = True
        ctx.yield_(3)
        assert len(seen.images) == drawn + 1
        assert not seen.shows(enhanced(state))

    driver.run(drive)


@pytest.mark.display
def test_its_own_keys_choose_the_pane_and_leave_it(driver: Driver, seen: Seen) -> None:
    state = driver.state

    def press(key: int, mods: int = 0) -> None:
        """As the system does."""
        driver.window.canvas.second_window._press(None, key, 0, glfw.PRESS, mods)

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        presenting.toggle_second(state)
        wait(ctx, lambda: seen.shows(enhanced(state)), "the enhanced frame")
        press(glfw.KEY_1)
        assert state.picture.pictures is not None
        original = state.picture.pictures.original
        wait(ctx, lambda: seen.shows(original), "the original")
        press(glfw.KEY_F11)
        window = seen.windows[-1]
        wait(ctx, lambda: bool(glfw.get_window_monitor(window)), "its full screen")  # type: ignore[arg-type]
        press(glfw.KEY_ESCAPE)
        wait(ctx, lambda: not glfw.get_window_monitor(window), "its place")  # type: ignore[arg-type]
        assert state.second_window.shown
        press(glfw.KEY_ESCAPE)
        wait(ctx, lambda: not state.second_window.shown, "its end")
        ctx.yield_(2)
        presenting.toggle_second(state)
        wait(ctx, lambda: len(seen.windows) == 2, "the window again")
        press(glfw.KEY_F5, glfw.MOD_SHIFT)
        wait(ctx, lambda: not state.second_window.shown, "its end by the keys that open it")
        ctx.yield_(2)
        assert driver.window.canvas.second_window._window is None

    driver.run(drive)


@pytest.mark.display
def test_it_ends_with_its_monitor_and_does_not_fill_the_one_that_is_left(driver: Driver, seen: Seen) -> None:
    """What GLFW does where a monitor is unplugged: the window leaves its full screen."""
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        presenting.toggle_second(state)
        wait(ctx, lambda: bool(seen.windows), "the window")
        presenting.fill_second(state, True)
        first = seen.windows[-1]
        wait(ctx, lambda: bool(glfw.get_window_monitor(first)), "its full screen")  # type: ignore[arg-type]
        glfw.set_window_monitor(first, None, 0, 0, 900, 700, glfw.DONT_CARE)  # type: ignore[arg-type]
        wait(ctx, lambda: not state.second_window.shown, "its end")
        assert state.window.toast is not None
        assert state.window.toast.message == second_window.LOST
        state.settings = replace(state.settings, second_place=(9000, 0, *SIZE), second_full_screen=True)
        ctx.key_press(chord("Shift+F5"))
        wait(ctx, lambda: len(seen.windows) == 2, "the window again")
        ctx.yield_(3)
        assert glfw.get_window_size(seen.windows[-1]) == SIZE  # type: ignore[arg-type]
        assert not state.second_window.full_screen

    driver.run(drive)


@pytest.mark.display
def test_it_comes_back_where_it_was_put(driver: Driver, seen: Seen) -> None:
    state, put = driver.state, (60, 30, 500, 300)

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        presenting.toggle_second(state)
        wait(ctx, lambda: bool(seen.windows), "the window")
        glfw.set_window_pos(seen.windows[-1], *put[:2])  # type: ignore[arg-type]
        glfw.set_window_size(seen.windows[-1], *put[2:])  # type: ignore[arg-type]
        wait(ctx, lambda: state.settings.second_place == put, "its place")
        presenting.toggle_second(state)
        ctx.yield_(3)
        presenting.toggle_second(state)
        wait(ctx, lambda: len(seen.windows) == 2, "the window again")
        ctx.yield_(2)
        window = seen.windows[-1]
        place = (*glfw.get_window_pos(window), *glfw.get_window_size(window))  # type: ignore[arg-type]
        assert place == put

    driver.run(drive)  # It ends with the second window open.
    assert load_settings(state.places.settings_file).second_place == put


def test_labels_have_their_colours_and_fit_the_window() -> None:
    said = [Tag("ENHANCED", "enhanced"), Tag("a long one " * 40)]
    image = label_image(said, (320, 240))
    assert image.shape[1] <= 320
    assert image.shape[2] == 4
    blue = np.array([33, 92, 153, 240])
    assert (np.abs(image.astype(int) - blue).max(axis=2) <= 1).any()
    assert image[0, 0, 3] == 0
