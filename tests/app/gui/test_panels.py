"""The draw functions in an ImGui context without a window: what they show, and what a click does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui, imgui_ctx, implot

from app.gui import actions, camera_actions, path_actions
from app.gui.command import Outside
from app.gui.commands import sections
from app.gui.comparison import SIDES
from app.gui.enhancing import PictureMaker, Pictures
from app.gui.keys import Keyboard
from app.gui.panels import overlays
from app.gui.panels.cameras import draw_cameras
from app.gui.panels.compare import draw_compare
from app.gui.panels.enhancement import draw_enhancement
from app.gui.panels.reconstruction import draw_reconstruction
from app.gui.panels.scene_marks import bounds
from app.gui.panels.timeline import draw_timeline
from app.gui.panels.view3d import PhotoTexture, draw_view3d, photo_over, view_tags
from app.gui.panels.welcome import Openers, draw_welcome
from app.gui.panes import Pane, pane
from app.gui.photos import read_photo
from app.gui.picking import pick
from app.gui.picture_view import Placement
from app.gui.state import AppState
from app.gui.textures import PLAIN, Marks, OnPane
from app.gui.viewing import draw_view
from app.gui.viewport import OnScreen
from app.gui.widgets import seconds
from enhance import EnhanceParams
from renderer.clip import ByteImage
from renderer.gaussians import DynamicGaussians
from renderer.train.events import Evaluated, Progress, Started
from tests.app.gui.conftest import FakeJob, outside

Draw = Callable[[], None]
NOTHING = Openers(lambda: None, lambda: None, lambda: None)


class Ui:
    """One full-window panel, with a mouse and a keyboard."""

    def __init__(self) -> None:
        self._context = imgui.create_context()
        self._plots = implot.create_context()
        self.io = imgui.get_io()
        self.io.display_size, self.io.delta_time = ImVec2(900, 700), 1 / 60
        self.io.set_ini_filename("")
        self.io.backend_flags |= imgui.BackendFlags_.renderer_has_textures
        self.time = 0.0

    def frame(self, draw: Draw) -> None:
        imgui.new_frame()
        try:
            imgui.set_next_window_pos(ImVec2(0, 0))
            imgui.set_next_window_size(ImVec2(900, 700))
            with imgui_ctx.begin("panel", None, imgui.WindowFlags_.no_decoration):
                draw()
        finally:
            imgui.render()

    def press(self, draw: Draw, *keys: imgui.Key) -> None:
        for down in (True, False):
            for key in keys:
                self.io.add_key_event(key, down)
            self.frame(draw)

    def drag(self, draw: Draw, start: tuple[float, float], end: tuple[float, float], button: int = 0) -> None:
        self.io.add_mouse_pos_event(*start)
        self.frame(draw)
        self.io.add_mouse_button_event(button, True)
        self.frame(draw)
        self.io.add_mouse_pos_event(*end)
        self.frame(draw)
        self.io.add_mouse_button_event(button, False)
        self.frame(draw)

    def scroll(self, draw: Draw, at: tuple[float, float], wheel: float) -> None:
        self.io.add_mouse_pos_event(*at)
        self.frame(draw)
        self.io.add_mouse_wheel_event(0, wheel)
        self.frame(draw)
        self.frame(draw)

    def close(self) -> None:
        implot.destroy_context(self._plots)
        imgui.destroy_context(self._context)


class Shown:
    """Stands for the textures: remembers which image each slot showed last."""

    def __init__(self) -> None:
        self.images: dict[str, ByteImage] = {}

    def part(
        self, slot: str, image: ByteImage, place: Placement, pane: tuple[float, float], marks: Marks = PLAIN
    ) -> OnPane | None:
        self.images[slot] = image
        return OnPane(imgui.ImTextureRef(1), 0, 0, 10, 10)


class StillViewport:
    """Shows the wanted view at once."""

    def show(self, state: AppState) -> OnScreen | None:
        request = state.view_request
        return None if request is None else OnScreen(imgui.ImTextureRef(1), (0, 0), (1, 1), request)

    def release(self) -> None: ...


def no_texture(image: ByteImage) -> imgui.ImTextureRef:
    return imgui.ImTextureRef(1)


class StillSecond(StillViewport):
    """The same of the second view."""

    def show(self, state: AppState) -> OnScreen | None:
        request = state.second_request
        return None if request is None else OnScreen(imgui.ImTextureRef(1), (0, 0), (1, 1), request)


def view3d(state: AppState, photo_texture: PhotoTexture = no_texture) -> None:
    draw_view3d(state, StillViewport(), StillSecond(), photo_texture, ())


@pytest.fixture
def ui() -> Iterator[Ui]:
    made = Ui()
    yield made
    made.close()


@pytest.fixture
def opened(state: AppState) -> AppState:
    """With both pictures made."""
    assert state.picture_request is not None
    state.pictures = list(PictureMaker().make(state.picture_request))[-1]
    return state


def pictures(state: AppState) -> Pictures:
    assert state.pictures is not None
    return state.pictures


def keyboard(state: AppState, reach: Outside | None = None) -> Draw:
    """A frame of nothing but keys."""
    keys = Keyboard()
    return lambda: keys.handle(state, sections(state, reach or outside()))


def texts(tags: list[tuple[str, object]]) -> str:
    return " | ".join(text for text, _ in tags)


def said(shown: Pane) -> str:
    return " | ".join(one.text for one in shown.tags)


def compare(state: AppState, shown: Shown) -> Draw:
    return lambda: draw_compare(state, shown, lambda: draw_welcome(state, NOTHING))


def test_left_is_the_original_and_right_the_enhanced(ui: Ui, opened: AppState) -> None:
    shown = Shown()
    ui.frame(compare(opened, shown))
    assert shown.images["left"] is pictures(opened).photo
    assert shown.images["right"] is pictures(opened).enhanced


def test_the_right_pane_says_enhanced_exactly_when_it_is(opened: AppState) -> None:
    def right() -> Pane:
        return pane(opened, pictures(opened), "right")

    whole = pictures(opened)
    for enhancing in (True, False):
        for peeking in (True, False):
            for partner in (whole.enhanced, None):
                opened.enhancing, opened.peeking = enhancing, peeking
                opened.pictures = replace(whole, enhanced=partner)
                is_enhanced = right().image is partner
                assert ("ENHANCED" in said(right())) == is_enhanced
                assert "ORIGINAL" in said(pane(opened, pictures(opened), "left"))


def test_frozen_and_stale_are_tagged_on_both_sides(opened: AppState) -> None:
    opened.frozen_index, opened.now = 0, 5.0
    opened.params = EnhanceParams(z=0.1)
    for side in SIDES:
        shown = said(pane(opened, pictures(opened), side))
        assert "FROZEN · frame 1" in shown
        assert "UPDATING" in shown


def test_the_wheel_zooms_at_the_pointer_and_a_double_click_fits(ui: Ui, opened: AppState) -> None:
    draw = compare(opened, Shown())
    ui.scroll(draw, (200, 400), 3.0)
    assert opened.picture_view.zoom is not None
    zoomed = opened.zoom
    ui.drag(draw, (200, 400), (230, 420))
    assert opened.zoom == pytest.approx(zoomed)
    assert opened.picture_view.center != (0.5, 0.5)
    for _ in range(2):
        ui.drag(draw, (200, 400), (200, 400))
    assert opened.picture_view.zoom is None


def test_both_panes_move_together_whichever_is_dragged(ui: Ui, opened: AppState) -> None:
    views = []
    for x in (200, 650):
        opened.picture_view = opened.picture_view.one_to_one(8.0)
        ui.drag(compare(opened, Shown()), (x, 400), (x + 25, 400))
        views.append(opened.picture_view)
        opened.picture_view = type(opened.picture_view)()
    assert views[0] == views[1]
    assert views[0].center[0] < 0.5


def test_without_a_clip_there_is_something_to_do(ui: Ui, state: AppState) -> None:
    state.clip = None
    pressed: list[str] = []
    openers = Openers(*(lambda name=name: pressed.append(name) for name in ("folder", "file", "phantom")))  # type: ignore[misc]
    spots: list[tuple[float, float]] = []

    def draw() -> None:
        draw_welcome(state, openers)
        low = imgui.get_item_rect_min()
        spots[:] = [(low.x + 20, low.y + 5)]

    ui.frame(draw)
    ui.drag(draw, spots[0], spots[0])
    assert pressed == ["phantom"]


def test_dragging_a_slider_is_live_and_one_undo(ui: Ui, opened: AppState) -> None:
    spots: dict[str, tuple[float, float]] = {}

    def draw() -> None:
        draw_enhancement(opened)
        window = imgui.get_window_pos()
        spots["d"] = (window.x + 300, window.y + 10 + 4.5 * imgui.get_frame_height_with_spacing())
        if not imgui.is_any_item_active():
            actions.settle_params(opened)

    ui.frame(draw)
    start = spots["d"]
    ui.drag(draw, start, (start[0] + 200, start[1]))
    moved = opened.params
    assert moved.d_factor != EnhanceParams().d_factor
    assert replace(moved, d_factor=1.0) == EnhanceParams()
    assert len(opened.past) == 2
    actions.undo(opened)
    assert opened.params == EnhanceParams()


@pytest.mark.parametrize(
    "status", ["none", "starting", "running", "paused", "finished", "failed", "cancelled"]
)
def test_the_reconstruction_panel_draws_every_state(ui: Ui, opened: AppState, status: str) -> None:
    run = opened.reconstruction
    run.status, run.input, run.failure = status, "enhanced", "out of memory"  # type: ignore[assignment]
    run.started = Started(0, 100, 30, ())
    run.progress = Progress(50, 100, 0.1, 25.0, 61.0, 3700.0, 30_000)
    run.curve = [Progress(1, 100, 0.5, 10.0, 1.0, 99.0, 20_000), run.progress]
    run.evaluated = [Evaluated(100, 24.0)]
    run.warnings = ["a warning"]
    ui.frame(lambda: draw_reconstruction(opened, FakeJob))
    ui.frame(lambda: draw_reconstruction(opened, FakeJob))


def test_the_panels_draw_at_the_very_start(ui: Ui, state: AppState) -> None:
    state.clip = None
    ui.frame(lambda: draw_enhancement(state))
    ui.frame(lambda: draw_reconstruction(state, FakeJob))
    ui.frame(lambda: draw_timeline(state, lambda: None, lambda image: imgui.ImTextureRef(1)))
    ui.frame(lambda: view3d(state))
    ui.frame(compare(state, Shown()))


def start_live(state: AppState, model: DynamicGaussians) -> None:
    actions.start_reconstruction(state, FakeJob)
    actions.show_live_model(state, model)


def test_the_3d_view_turns_moves_and_zooms(ui: Ui, opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    draw: Draw = lambda: view3d(opened)  # noqa: E731
    ui.frame(draw)
    middle = np.array([[0.0, 0.0, 50.0]])

    def seen(point: np.ndarray) -> tuple[np.ndarray, float]:
        assert opened.view_request is not None
        at, depth = opened.view_request.camera.project(point)
        return at[0], float(depth[0])

    start, _ = seen(middle)
    ui.drag(draw, (400, 300), (500, 340))
    assert seen(middle)[0] == pytest.approx(start)
    assert seen(middle * 0.9)[0][0] > start[0] + 1  # The near side follows the hand.
    assert seen(middle * 0.9)[0][1] > start[1] + 1
    ui.drag(draw, (400, 300), (450, 320), button=1)
    assert seen(middle)[0] == pytest.approx(start + np.array((50, 20)))
    ui.scroll(draw, (400, 300), 2.0)
    assert seen(middle)[1] < 45
    assert not opened.view_dragged


def test_a_double_click_asks_for_the_point_under_the_pointer(
    ui: Ui, opened: AppState, model: DynamicGaussians
) -> None:
    start_live(opened, model)
    draw: Draw = lambda: view3d(opened)  # noqa: E731
    ui.frame(draw)
    for _ in range(2):
        ui.drag(draw, (400, 300), (400, 300))
    assert opened.viewer.pick is not None
    assert opened.viewer.free is None
    width, height = opened.view_size
    left, top = (900 - width) // 2, 700 - imgui.get_style().window_padding.y - height
    assert opened.viewer.pick.pixel == (400 - left, 300 - top)


def test_the_photo_lies_pixel_for_pixel_over_the_snapped_view(
    ui: Ui, opened: AppState, model: DynamicGaussians
) -> None:
    start_live(opened, model)
    assert opened.clip is not None
    actions.seek(opened, 4)
    camera_actions.toggle_snap(opened)
    wish = opened.photo_request
    assert wish is not None
    (opened.viewer.photo,) = read_photo(wish)
    laid: list[ByteImage] = []

    def draw() -> None:
        view3d(opened, lambda image: laid.append(image) or imgui.ImTextureRef(1))

    ui.frame(draw)
    request = opened.view_request
    assert request is not None
    assert request.camera == opened.clip.cameras[4]
    (view,) = draw_view(request)
    assert view.image.shape == laid[0].shape
    np.testing.assert_array_equal(laid[0], opened.clip.read_image(4))
    corner, size = ImVec2(10, 20), ImVec2(300, 200)
    (low, high), zoom = bounds(request.camera, corner, size), 200 / 40
    assert (high.x - low.x, high.y - low.y) == (zoom * 48, zoom * 40)  # Square pixels, all of them.
    assert "PHOTO 50 %" in texts(view_tags(opened, StillViewport().show(opened)))
    ui.drag(draw, (400, 300), (420, 300))
    assert not opened.viewer.snapped
    assert photo_over(opened) is None


def test_clicks_measure_and_drags_still_turn(ui: Ui, opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    draw: Draw = lambda: view3d(opened)  # noqa: E731
    ui.frame(draw)
    ui.drag(draw, (400, 300), (400, 300))
    assert opened.viewer.pick is None
    camera_actions.toggle_measuring(opened)
    ui.drag(draw, (400, 300), (460, 300))
    assert opened.viewer.pick is None
    assert opened.viewer.free is not None
    camera_actions.reset_view(opened)
    for x in (420, 480):
        ui.drag(draw, (x, 330), (x, 330))
        wish = opened.viewer.pick
        assert wish is not None
        assert wish.purpose == "measure"
        (answer,) = pick(wish)
        camera_actions.take_point(opened, wish, answer)
        ui.frame(draw)
    request = opened.view_request
    assert request is not None
    expected = 60 / request.camera.fx * 50.0  # On the model's sheet, which is 50 before the camera.
    assert opened.viewer.measurement.distance == pytest.approx(expected, rel=1e-3)
    assert "mm" in opened.viewer.measurement.text("mm", opened.time)
    camera_actions.toggle_measuring(opened)
    assert opened.viewer.measurement.points == ()


def test_two_reconstructions_share_camera_time_and_hand(
    ui: Ui, opened: AppState, model: DynamicGaussians
) -> None:
    start_live(opened, model)
    assert opened.model is not None
    opened.second.shown = replace(opened.model, name="another run", live=False)
    draw: Draw = lambda: view3d(opened)  # noqa: E731
    ui.frame(draw)
    ui.frame(draw)
    width = opened.view_size[0]
    assert width == pytest.approx((900 - 20) / 2, abs=5)
    for x in (200, 700):  # On either of them.
        before = opened.view_request
        ui.drag(draw, (x, 300), (x + 40, 320))
        first, second = opened.view_request, opened.second_request
        assert first is not None
        assert second is not None
        assert first != before
        assert second == replace(first, shown=opened.second.shown)
        assert not opened.view_dragged
    actions.seek(opened, 4)
    assert opened.second_request is not None
    assert opened.second_request.time == opened.time
    shown = [StillViewport().show(opened), StillSecond().show(opened)]
    said = [texts(view_tags(opened, one)) for one in shown]
    assert "another run" not in said[0]
    assert "another run" in said[1]
    assert "FREE VIEW" in said[0]
    camera_actions.toggle_snap(opened)
    assert opened.second_request.camera == opened.model.cameras[4]
    wish = opened.photo_request
    assert wish is not None
    (opened.viewer.photo,) = read_photo(wish)
    laid: list[ByteImage] = []
    ui.frame(lambda: view3d(opened, lambda image: laid.append(image) or imgui.ImTextureRef(1)))
    assert len(laid) == 2


def test_keys_of_flight_fly_and_do_nothing_else(ui: Ui, opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    saved: list[str] = []
    draw = keyboard(opened, outside(screenshot=lambda: saved.append("picture")))
    ui.press(draw, imgui.Key.g)
    assert opened.viewer.flying
    ui.press(draw, imgui.Key.s, imgui.Key.a)
    free = opened.viewer.free
    assert free is not None
    assert free.camera.position[0] == free.camera.position[2] < 0
    assert not saved
    assert not opened.viewer.moving
    ui.press(draw, imgui.Key.home)
    ui.press(draw, imgui.Key.s)
    assert (opened.viewer.free, saved) == (None, ["picture"])


def test_the_live_preview_and_reduced_views_are_tagged(opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    opened.view_size = (64, 48)
    request = opened.view_request
    assert request is not None
    shown = OnScreen(imgui.ImTextureRef(1), (0, 0), (1, 1), request.scaled(0.5))
    text = texts(view_tags(opened, shown))
    assert "LIVE PREVIEW · iteration 0 / 3000" in text
    assert "REDUCED RESOLUTION" in text
    actions.show_finished_model(opened, model)
    assert opened.view_request is not None
    text = texts(view_tags(opened, replace(shown, request=opened.view_request)))
    assert "LIVE" not in text
    assert "REDUCED" not in text


def test_keys_do_what_the_help_says(ui: Ui, opened: AppState) -> None:
    saved: list[str] = []
    draw = keyboard(opened, outside(screenshot=lambda: saved.append("picture")))
    key = imgui.Key
    ui.press(draw, key.e)
    assert not opened.enhancing
    ui.press(draw, key.e)
    ui.press(draw, key.escape)
    assert not opened.enhancing
    ui.press(draw, key.period)
    assert opened.frame_index == 1
    ui.press(draw, key.comma)
    ui.press(draw, key.f)
    assert (opened.frame_index, opened.frozen_index) == (0, 0)
    ui.press(draw, key.p)
    assert opened.playing
    ui.press(draw, key.s)
    assert saved == ["picture"]
    ui.press(draw, key._1)
    assert opened.picture_view.zoom == 1.0
    ui.press(draw, key.mod_shift, key.slash)
    assert opened.help_open
    ui.press(draw, key.mod_ctrl, key.e)  # Another chord than E.
    assert not opened.enhancing


def test_space_peeks_only_while_it_is_held(ui: Ui, opened: AppState) -> None:
    draw = keyboard(opened)
    ui.io.add_key_event(imgui.Key.space, True)
    ui.frame(draw)
    assert opened.peeking
    assert pane(opened, pictures(opened), "right").image is pictures(opened).photo
    ui.io.add_key_event(imgui.Key.space, False)
    ui.frame(draw)
    assert not opened.peeking


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
    actions.fail(state, "expected a clip, got a folder without pictures: " + "a/long/path/" * 20)
    actions.announce(state, "saved clip.png")
    state.help_open = True

    def draw() -> None:
        overlays.draw_banner(state)
        overlays.draw_toast(state)
        overlays.draw_help(state, sections(state, outside()))
        overlays.draw_log(state, lambda text: None)

    for _ in range(3):
        ui.frame(draw)
    assert state.help_open
    np.testing.assert_equal(len(state.log), 2)


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
    assert copied[1].splitlines() == list(state.log)
    ui.scroll(draw, (40, 300), 20.0)  # Back to the first: there it stays.
    for _ in range(20):  # Scrolling glides.
        ui.frame(draw)
    actions.say(state, "line 60")
    ui.frame(draw)
    ui.drag(draw, (30, 38), (30, 38))
    assert copied[2] == "line 0"


@pytest.mark.parametrize(
    ("duration", "text"),
    [(0.4, "0 s"), (42, "42 s"), (185, "3 min 05 s"), (4320, "1 h 12 min"), (59.6, "1 min 00 s")],
)
def test_durations_are_said_as_people_do(duration: float, text: str) -> None:
    assert seconds(duration) == text


def test_the_cameras_panel_draws_every_state(ui: Ui, opened: AppState, model: DynamicGaussians) -> None:
    draw: Draw = lambda: draw_cameras(opened, lambda: None)  # noqa: E731
    ui.frame(draw)
    start_live(opened, model)
    ui.frame(draw)
    for _ in range(2):
        path_actions.save_view(opened)
        path_actions.add_keyframe(opened)
        ui.frame(draw)
    path_actions.toggle_path(opened)
    ui.frame(draw)


def test_keys_keep_views_and_keyframes(ui: Ui, opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    draw = keyboard(opened)
    for key in (imgui.Key.b, imgui.Key.i, imgui.Key.i, imgui.Key.l):
        ui.press(draw, key)
    assert len(opened.cameras.views.named) == 1
    assert len(opened.cameras.views.path.keyframes) == 2
    assert opened.cameras.playing
