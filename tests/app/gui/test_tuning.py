"""The tuning grid of the window: its cells are the window's own pictures, and it never stands in the way."""

from __future__ import annotations

import math

import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui

from app.enhancement.amounts import AMOUNTS
from app.enhancement.frame_enhancer import PictureMaker
from app.enhancement.measures import METRICS, Measures
from app.enhancement.setting_words import in_the_paper, said
from app.gui.actions import arriving, enhancement_actions, history_actions, tuning_actions
from app.gui.commands.keys import chord
from app.gui.panels.tuning import draw_tuning, in_words
from app.gui.session_file import Choice
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.work.opening import Opened
from app.gui.work.settings import Places
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.clip import ByteImage, Clip
from tests.app.gui.conftest import image_of, make_clip
from tests.app.gui.driver import Driver, wait
from tests.app.gui.settling import served
from tests.app.gui.test_keys import keyboard
from tests.app.gui.ui import Shown, Ui


def turn(state: AppState, channels: Channels) -> None:
    """One frame, with the worker's share done in between."""
    update(state, channels, state.window.now + 0.01)
    for channel in served(channels):
        channel.run_waiting()


def finish(state: AppState, channels: Channels) -> None:
    for _ in range(100):
        turn(state, channels)
        if not state.tuning.running:
            return
    raise AssertionError("the grid does not end")


def test_every_cell_is_the_window_s_own_picture(state: AppState, channels: Channels) -> None:
    state.enhancement.scope, state.enhancement.params = "clip", EnhanceParams(z=0.3)
    state.tuning.choices = (Choice("d_factor", 0.0, 2.0, 3), Choice("p", 0.2, 0.8, 2))
    tuning_actions.start_grid(state)
    finish(state, channels)
    grid = state.tuning.grid
    assert grid is not None
    assert (len(grid.settings), grid.columns) == (6, 2)
    assert set(state.tuning.cells) == set(grid.settings)
    setting = grid.settings[-1]
    assert setting.params == EnhanceParams(z=0.3, d_factor=2.0, p=0.8)
    tuning_actions.look_at(state, setting)
    turn(state, channels)
    turn(state, channels)
    tuning_actions.use_setting(state, setting)
    request = state.picture_request
    assert state.tuning.whole is not None
    assert request is not None
    shown = list(PictureMaker().make(request))[-1]
    np.testing.assert_array_equal(state.tuning.whole.image, shown.enhanced)


def test_use_is_one_step_of_undo(state: AppState, channels: Channels) -> None:
    tuning_actions.start_grid(state)
    finish(state, channels)
    assert state.tuning.grid is not None
    tuning_actions.use_setting(state, state.tuning.grid.settings[0])
    assert state.enhancement.params == state.tuning.grid.settings[0].params
    history_actions.undo(state)
    assert state.enhancement.params == EnhanceParams()


def test_a_setting_is_taken_with_the_statistics_that_it_was_tried_with(
    state: AppState, channels: Channels
) -> None:
    state.enhancement.scope, state.enhancement.pixels = "image", "tissue"
    tuning_actions.start_grid(state)
    finish(state, channels)
    assert state.tuning.grid is not None
    setting = state.tuning.grid.settings[0]
    enhancement_actions.set_params(state, setting.params)
    assert state.is_set(setting)
    state.enhancement.scope, state.enhancement.pixels = "clip", "all"
    enhancement_actions.settle_params(state)
    assert not state.is_set(setting)  # It looks otherwise.
    tuning_actions.use_setting(state, setting)
    assert (state.enhancement.scope, state.enhancement.pixels) == ("image", "tissue")
    assert state.is_set(setting)
    history_actions.undo(state)
    assert (state.enhancement.scope, state.enhancement.pixels) == ("clip", "all")


def test_a_cell_at_a_time_so_that_sliders_are_served_in_between(state: AppState, channels: Channels) -> None:
    tuning_actions.start_grid(state)
    for _ in range(3):
        turn(state, channels)
    tried = len(state.tuning.cells)
    assert 0 < tried < 12
    enhancement_actions.set_params(state, EnhanceParams(d_factor=0.7))
    turn(state, channels)
    turn(state, channels)
    assert state.picture.pictures is not None
    assert state.picture.pictures.request.params == EnhanceParams(d_factor=0.7)
    assert len(state.tuning.cells) < 12
    tuning_actions.stop_grid(state)
    for _ in range(3):
        turn(state, channels)
    assert len(state.tuning.cells) <= tried + 3


def test_the_order_is_that_of_the_measure(state: AppState, channels: Channels) -> None:
    tuning_actions.start_grid(state)
    finish(state, channels)
    state.tuning.sort = "noise_gain"
    values = [state.tuning.cells[one].measures.noise_gain for one in state.tuning.in_order]
    assert values == sorted(values)
    assert len(values) == 12


def test_whole_numbers_stay_whole(state: AppState) -> None:
    state.tuning.choices = (Choice("subsample", 1, 4, 6), Choice())
    tuning_actions.start_grid(state)
    assert state.tuning.grid is not None
    assert [one.params for one in state.tuning.grid.settings] == [
        EnhanceParams(subsample=factor) for factor in (1, 2, 3, 4)
    ]


def test_what_cannot_be_tried_is_a_sentence(state: AppState) -> None:
    state.tuning.choices = (Choice("p"), Choice("p"))
    tuning_actions.start_grid(state)
    assert state.window.banner is not None
    assert "both of Detail" in state.window.banner.message
    state.enhancement.params, state.window.banner = VesselParams(), None
    state.tuning.choices = (Choice("z"), Choice())
    tuning_actions.start_grid(state)
    assert state.window.banner is not None
    assert "nothing to try" in state.window.banner.message
    assert state.tuning.grid is None


def test_a_clip_that_is_gone_stops_the_grid(state: AppState, channels: Channels) -> None:
    def gone(index: int) -> ByteImage:
        raise OSError("no such file")

    object.__setattr__(state.source.clip, "read_image", gone)
    tuning_actions.start_grid(state)
    finish(state, channels)
    assert state.window.banner is not None
    assert state.tuning.cells == {}


def test_another_clip_has_no_grid(state: AppState, channels: Channels, clip: Clip) -> None:
    tuning_actions.start_grid(state)
    turn(state, channels)
    choices = state.tuning.choices
    arriving.show_opened(state, clip.path, Opened(make_clip(clip.path)))
    assert (state.tuning.grid, state.tuning.choices) == (None, choices)
    update(state, channels, state.window.now + 0.01)
    assert state.tuning.cells == {}


def test_values_are_said_in_the_words_of_the_sliders(state: AppState) -> None:
    state.tuning.choices = (Choice("z", 0.7, 0.1, 3), Choice("d_factor", 3.0, 1 / 3, 3))
    tuning_actions.start_grid(state)
    assert state.tuning.grid is not None
    words = [said(one) for one in state.tuning.grid.settings]
    assert words[0] == "Brightness 0.30 · Colour 0.25"
    assert words[4] == "Brightness 0.60 · Colour 0.50"  # Evenly spaced as it is shown.
    assert words[8] == "Brightness 0.90 · Colour 0.75"
    assert in_the_paper(state.tuning.grid.settings[4]) == "z 0.40 · d-factor 1.00"
    tuning_actions.use_setting(state, state.tuning.grid.settings[4])
    assert state.window.toast is not None
    assert "Brightness 0.60" in state.window.toast.message


def test_what_cannot_be_measured_is_a_dash() -> None:
    measures = Measures(**dict.fromkeys(METRICS, 1.0) | {"vessel_contrast": math.nan})
    assert in_words(measures) == "Contrast — · noise gain 1.00 · DV/BV 1.000"


def test_the_original_is_the_first_tile_and_stands_beside_a_cell(
    ui: Ui, state: AppState, channels: Channels
) -> None:
    shown = Shown()
    tuning_actions.start_grid(state)
    finish(state, channels)
    ui.frame(lambda: draw_tuning(state, shown))
    original = image_of(0)
    np.testing.assert_array_equal(shown.images["tile original"], original)  # It is small.
    tuning_actions.look_at(state, state.tuning.in_order[0])
    turn(state, channels)
    turn(state, channels)
    ui.frame(lambda: draw_tuning(state, shown))
    np.testing.assert_array_equal(shown.images["tuning original"], original)
    assert state.tuning.whole is not None
    assert shown.images["tuning tried"] is state.tuning.whole.image


def test_arrows_lead_to_neighbours_and_escape_back(ui: Ui, state: AppState, channels: Channels) -> None:
    shown, keys, key = Shown(), keyboard(state), imgui.Key

    def draw() -> None:
        draw_tuning(state, shown)
        keys()

    tuning_actions.start_grid(state)
    finish(state, channels)
    ui.frame(draw)
    tuning_actions.look_at(state, state.tuning.in_order[0])
    seen = []
    for press in (
        key.right_arrow,
        key.down_arrow,
        key.left_arrow,
        key.left_arrow,
        key.up_arrow,
        key.up_arrow,
    ):
        ui.press(draw, press)
        assert state.tuning.chosen is not None
        seen.append(state.tuning.chosen.places)
    assert seen == [(0, 1), (1, 1), (1, 0), (1, 0), (0, 0), (0, 0)]
    assert state.timeline.frame_index == 0
    ui.press(draw, key.escape)
    assert state.tuning.chosen is None
    ui.press(draw, key.right_arrow)
    assert state.timeline.frame_index == 1
    tuning_actions.look_at(state, state.tuning.in_order[0])
    state.tuning.in_sight = False  # Behind another tab, the keys are of the clip.
    ui.press(keys, key.right_arrow)
    assert state.timeline.frame_index == 2


def test_both_halves_have_one_zoom(ui: Ui, state: AppState, channels: Channels) -> None:
    tuning_actions.start_grid(state)
    finish(state, channels)
    tuning_actions.look_at(state, state.tuning.in_order[0])
    turn(state, channels)
    turn(state, channels)
    draw = lambda: draw_tuning(state, Shown())  # noqa: E731
    ui.frame(draw)
    assert state.tuning.view.zoom is None
    ui.scroll(draw, (200, 400), 1)
    near = state.tuning.view.zoom
    ui.scroll(draw, (700, 400), 1)
    assert near is not None
    assert state.tuning.view.zoom == pytest.approx(1.15 * near)
    before = state.tuning.view.center
    ui.drag(draw, (700, 400), (650, 400))
    assert state.tuning.view.center[0] > before[0]
    tuning_actions.go(state, right=1)
    assert state.tuning.view.zoom == pytest.approx(1.15 * near)  # The neighbour is seen at the same place.


class NoTextures:
    """In the place of OpenGL."""

    def part(self, *args: object) -> None:
        return None

    def whole(self, slot: str, image: ByteImage) -> imgui.ImTextureRef:
        return imgui.ImTextureRef(0)

    def lay(self, *args: object) -> None: ...


def test_the_panel_draws_in_every_state(ui: Ui, state: AppState, channels: Channels) -> None:
    textures = NoTextures()
    ui.frame(lambda: draw_tuning(AppState(state.places), textures))
    ui.frame(lambda: draw_tuning(state, textures))
    tuning_actions.start_grid(state)
    ui.frame(lambda: draw_tuning(state, textures))
    finish(state, channels)
    for metric in ("", *METRICS):
        state.tuning.sort = metric
        ui.frame(lambda: draw_tuning(state, textures))
        assert state.tuning.sort == metric
    tuning_actions.look_at(state, state.tuning.in_order[0])
    ui.frame(lambda: draw_tuning(state, textures))
    turn(state, channels)
    turn(state, channels)
    ui.frame(lambda: draw_tuning(state, textures))


@pytest.mark.display
def test_from_choosing_to_using_in_the_window(places: Places) -> None:
    driver = Driver(places)
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        ctx.item_click("//Images/**/###phantom")
        wait(ctx, lambda: state.picture.pictures is not None and not state.pictures_are_stale, "the phantom")
        ctx.key_press(chord("Ctrl+T"))
        ctx.yield_(3)
        ctx.item_drag_with_delta("//Tuning/##from##0", ImVec2(40, 0))
        # From where it was, not to where the pointer is: the field has no handle that would cover its number.
        assert 0.3 < AMOUNTS["d_factor"].of_parameter(float(str(state.tuning.choices[0].first))) < 0.48
        ctx.item_click("//Tuning/###try")
        wait(ctx, lambda: len(state.tuning.cells) == 12 and not state.tuning.running, "the grid")
        ctx.yield_(3)
        ctx.item_click("//Tuning/**/tile0-1")
        wait(ctx, lambda: state.tuning.is_looked_at, "the cell as it is")
        ctx.yield_(2)
        ctx.item_click("//Tuning/###use")
        assert state.tuning.chosen is not None
        assert state.enhancement.params == state.tuning.chosen.params != EnhanceParams()
        ctx.item_click("//Tuning/###back")
        ctx.yield_(2)

    driver.run(drive)
    assert len(state.tuning.cells) == 12


@pytest.mark.display
def test_tiles_grow_and_shrink_in_the_window(places: Places) -> None:
    driver = Driver(places)
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        def width() -> float:
            ctx.yield_(2)
            return float(ctx.item_info("//Tuning/**/tile0-0").rect_full.get_width())

        ctx.item_click("//Images/**/###phantom")
        wait(ctx, lambda: state.picture.pictures is not None and not state.pictures_are_stale, "the phantom")
        ctx.key_press(chord("Ctrl+T"))
        ctx.yield_(3)
        ctx.item_click("//Tuning/###try")
        wait(ctx, lambda: len(state.tuning.cells) == 12, "the grid")
        whole = width()
        last = ctx.item_info("//Tuning/**/tile0-2").rect_full
        panel = ctx.window_info("//Tuning").window
        assert last.max.x <= panel.pos.x + panel.size.x  # All columns are in sight.
        ctx.item_click("//Tuning/+##size")
        assert width() == pytest.approx(1.25 * whole, abs=1)
        ctx.item_click("//Tuning/-##size")
        ctx.item_click("//Tuning/-##size")
        assert width() == pytest.approx(0.8 * whole, abs=1)
        ctx.item_click("//Tuning/###whole size")
        assert width() == pytest.approx(whole, abs=1)

    driver.run(drive)


def test_all_parameters_are_in_sight_when_one_is_chosen(ui: Ui, state: AppState) -> None:
    state.enhancement.params, textures = VesselParams(), NoTextures()

    def draw() -> None:
        draw_tuning(state, textures)

    for _ in range(2):
        ui.frame(draw)
    low = imgui.internal.find_window_by_name("panel").pos
    ui.drag(draw, (low.x + 60, low.y + 20), (low.x + 60, low.y + 20))
    for _ in range(3):
        ui.frame(draw)
    assert imgui.internal.find_window_by_name("##Combo_00").scroll_max.y == 0
