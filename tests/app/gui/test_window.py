"""The whole window under an X server, driven by the ImGui test engine; and what it may import."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import moderngl
import numpy as np
import pytest
from imgui_bundle import ImVec2, hello_imgui, imgui

from app.files.provenance import read_provenance
from app.gui.actions import actions
from app.gui.commands.keys import chord
from app.gui.drawing.textures import Textures
from app.gui.drawing.viewport import GraphicsViewport
from app.gui.state.app_state import AppState
from app.gui.work.presets import load_presets, presets_file
from app.gui.work.settings import Places, Settings, load_clips, load_settings
from assets import phantom_path
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.gaussians import DynamicGaussians
from renderer.splat_files.inria_ply import ply_bytes
from renderer.train.events import Finished, Progress, Started
from renderer.unobserved import GREY
from tests.app.gui.driver import Driver, enhanced, is_settled, wait


def test_the_window_process_never_imports_torch() -> None:
    code = "import sys, app.gui.window; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], timeout=60, check=False).returncode == 0


@pytest.mark.display
def test_a_session_from_first_start_to_a_saved_picture(places: Places, model: DynamicGaussians) -> None:
    driver = Driver(places, Settings())
    state, jobs = driver.state, driver.jobs

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        ctx.item_click("//Before you begin/I understand")
        ctx.item_click("//Images/**/###phantom")
        wait(ctx, lambda: is_settled(state), "the enhanced phantom")
        before = enhanced(state)
        ctx.item_input_value("//Enhancement/**/##d_factor", 0.25)
        wait(
            ctx, lambda: state.enhancement.params.d_factor == 3.0 and is_settled(state), "the new enhancement"
        )
        assert not np.array_equal(before, enhanced(state))
        ctx.key_press(chord("Ctrl+Z"))
        wait(ctx, lambda: state.enhancement.params.d_factor is None and is_settled(state), "undo")
        np.testing.assert_array_equal(before, enhanced(state))

        ctx.item_click("//Reconstruction/###start")
        wait(ctx, lambda: bool(jobs), "the job")
        jobs[0].inbox = [Started(0, 20, 30, ()), Progress(10, 20, 0.2, 22.0, 1.0, 1.0, 30)]
        jobs[0].model = model
        wait(ctx, lambda: state.scene.view is not None, "the first preview")
        ctx.item_click("//Reconstruction/###pause")
        ctx.item_click("//**/##frame")
        wait(ctx, lambda: state.timeline.frame_index > 5 and is_settled(state), "scrubbing")
        jobs[0].inbox = [Finished(20, 2.0, model)]
        wait(ctx, lambda: state.scene.model is not None and not state.scene.model.live, "the finished model")
        ctx.key_press(imgui.Key.s)
        wait(
            ctx,
            lambda: state.window.toast is not None and "saved" in state.window.toast.message,
            "the saved picture",
        )

    driver.run(drive)
    assert load_settings(places.settings_file).acknowledged
    assert jobs[0].told == ["start", "pause", "close"]
    (saved,) = places.pictures.glob("phantom-*.png")
    facts = read_provenance(saved)
    assert {"frame", "views", "source"} <= facts.keys()
    assert {"params", "statistics"} <= facts["panes"][1].keys()
    shot = hello_imgui.final_app_window_screenshot()
    assert np.ptp(np.asarray(shot)) > 200


@pytest.mark.display
def test_two_pictures_are_compared_in_every_way(places: Places) -> None:
    """Sources from the lists above panes, modes by key, the wipe's line by hand, pixels at the mouse."""
    driver = Driver(places, opens=phantom_path())
    state, key = driver.state, imgui.Key

    def ready() -> bool:
        return is_settled(state) and not state.comparing.waits

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        ctx.key_press(chord("Shift+A"))
        wait(ctx, lambda: "A" in state.enhancement.stored, "the stored setting")
        ctx.set_ref("//Images")
        ctx.combo_click("##left/Stored settings A")
        ctx.combo_click("##right/Method: CLAHE")
        ctx.set_ref("")
        wait(
            ctx,
            lambda: (state.comparing.chosen.left, state.comparing.chosen.right) == ("A", "clahe"),
            "the sources",
        )
        wait(ctx, ready, "both pictures")
        ctx.mouse_move("//Images/left")
        ctx.yield_(2)
        assert state.picture.pointer is not None
        ctx.key_press(key.w)
        ctx.yield_(2)
        ctx.item_drag_with_delta("//Images/line", ImVec2(-100, 0))
        assert 0.02 < state.comparing.chosen.wipe < 0.48
        ctx.item_double_click("//Images/line")
        assert state.comparing.chosen.wipe == 0.5
        assert state.picture.view == type(state.picture.view)()
        for press, mode in ((key.d, "difference"), (key.t, "flip"), (key.v, "side by side")):
            ctx.key_press(press)
            wait(ctx, lambda mode=mode: state.comparing.chosen.mode == mode and ready(), mode)  # type: ignore[misc]
        wait(ctx, lambda: state.comparing.difference is not None, "the difference")
        ctx.key_press(key.z)
        ctx.yield_(2)
        assert state.comparing.chosen.zebra
        ctx.key_press(key.escape)
        ctx.yield_(2)
        assert state.enhancement.active
        ctx.key_press(chord("Shift+W"))
        wait(ctx, lambda: not state.enhancement.active, "white light")

    driver.run(drive)


@pytest.mark.display
def test_a_preset_is_kept_by_name_and_windows_come_and_go(places: Places) -> None:
    driver = Driver(places, opens=phantom_path())
    state, key = driver.state, imgui.Key

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        ctx.set_ref(ctx.window_info("//Enhancement/details/###windows/content").id_)
        ctx.item_click("Add window")
        ctx.set_ref("")
        wait(ctx, lambda: len(scales_of(state)) == 4 and is_settled(state), "a fourth window")
        ctx.item_click("//Enhancement/Save…")
        ctx.key_chars("mine")
        ctx.key_press(key.enter)
        wait(ctx, lambda: "mine" in state.enhancement.presets, "the preset")
        ctx.set_ref("//Enhancement")
        ctx.combo_click("##preset/Vessels")
        wait(ctx, lambda: isinstance(state.enhancement.params, VesselParams), "the other preset")
        ctx.combo_click("##preset/mine")
        ctx.set_ref("")
        wait(ctx, lambda: scales_of(state) == (4, 16, 64, 128) and is_settled(state), "the own preset")
        for tab in ("Curves", "Measures"):
            ctx.item_click(f"//Enhancement/details/{tab}")
            ctx.yield_(3)
        wait(ctx, lambda: is_measured(state), "the measures")

    def scales_of(state: AppState) -> tuple[int, ...]:
        return state.enhancement.params.radii if isinstance(state.enhancement.params, EnhanceParams) else ()

    def is_measured(state: AppState) -> bool:
        return (
            state.picture.measured is not None and state.picture.measured.pictures is state.picture.pictures
        )

    driver.run(drive)
    presets, trouble = load_presets(presets_file(places))
    assert (list(presets), trouble) == (["mine"], "")


@pytest.mark.display
def test_a_clip_is_trimmed_and_masked_and_stays_so(places: Places) -> None:
    driver = Driver(places, opens=phantom_path())
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        wait(ctx, lambda: state.timeline.strip is not None, "the frame strip")
        ctx.item_click("//**/strip")
        wait(ctx, lambda: state.timeline.frame_index > 2 and is_settled(state), "the frame in the middle")
        ctx.item_click("//**/Out")
        assert state.source.span == (0, state.timeline.frame_index)
        before = state.picture.pictures.statistics if state.picture.pictures else None
        ctx.item_click("//**/###mask")
        ctx.item_click("//**/Text box: draw")
        wait(ctx, lambda: state.picture.mask_tool == "text", "the tool")
        ctx.item_drag_with_delta("//Images/left", ImVec2(90, 60))
        wait(ctx, lambda: state.source.part.mask.text is not None and not state.picture.mask_tool, "the box")
        wait(ctx, lambda: is_settled(state), "the new statistics")
        assert state.picture.pictures is not None
        assert state.picture.pictures.statistics != before
        assert state.picture.view.zoom is None  # Drawn, not panned.
        wait(ctx, lambda: state.picture.left_out is not None, "the tint")
        ctx.key_press(chord("Shift+M"))
        wait(ctx, lambda: not state.picture.overlay, "the tint's end")

    driver.run(drive)
    (kept,) = load_clips(places.config).values()
    assert kept.part == state.source.part


@pytest.mark.display
def test_a_mistake_is_a_banner_that_can_be_dismissed(places: Places) -> None:
    driver = Driver(places)
    actions.open_path(driver.state, places.config / "nothing.mp4")

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: driver.state.window.banner is not None, "the banner")
        ctx.yield_(3)
        ctx.item_click("//##banner/Dismiss")
        wait(ctx, lambda: driver.state.window.banner is None, "its end")

    driver.run(drive)
    assert driver.state.source.clip is None


@pytest.mark.display
def test_keys_reach_the_state_whatever_has_the_focus(places: Places) -> None:
    driver = Driver(places)

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        driver.window.drop(None, [str(phantom_path()), "another.mp4"])
        wait(ctx, lambda: is_settled(driver.state), "the phantom")
        assert any("of 2 items only" in line for line in driver.state.window.log)
        ctx.item_click("//Enhancement/##Method")
        ctx.key_press(imgui.Key.escape)  # Closes the list, and that alone.
        ctx.item_click("//Enhancement/**/Auto##z")
        assert driver.state.enhancement.active
        ctx.key_down(imgui.Key.o)
        wait(ctx, lambda: driver.state.enhancement.peeking, "the original")
        ctx.key_up(imgui.Key.o)
        wait(ctx, lambda: not driver.state.enhancement.peeking, "the enhanced frame")
        for key, frame in ((imgui.Key.right_arrow, 1), (imgui.Key.end, 23), (imgui.Key.home, 0)):
            ctx.key_press(key)
            ctx.yield_(2)
            assert driver.state.timeline.frame_index == frame
        for playing in (True, False):
            ctx.key_press(imgui.Key.space)
            ctx.yield_(2)
            assert driver.state.timeline.playing == playing
        ctx.key_press(imgui.Key.home)
        ctx.yield_(2)
        ctx.key_press(imgui.Key.f)
        ctx.key_press(imgui.Key.e)
        wait(ctx, lambda: not driver.state.enhancement.active, "white light")

    driver.run(drive)
    assert driver.state.timeline.frozen_index == 0


@pytest.mark.display
def test_a_graphics_card_s_drawing_lives_beside_the_window_s_own(
    places: Places, model: DynamicGaussians, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Drawn by OpenGL in the window's context, the view is in its pane and the controls are still there."""

    def on_the_card(ctx: moderngl.Context, textures: Textures, state: AppState) -> GraphicsViewport:
        state.scene.processor_draws = False
        return GraphicsViewport(ctx, textures)

    monkeypatch.setattr("app.gui.frame.canvas.ChosenViewport", on_the_card)
    driver = Driver(places, opens=phantom_path())
    state, jobs = driver.state, driver.jobs
    pane: list[float] = []

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        ctx.item_click("//Reconstruction/###start")
        wait(ctx, lambda: bool(jobs), "the job")
        jobs[0].model = model
        wait(ctx, lambda: state.view_request is not None, "the view")
        ctx.yield_(3)
        box = ctx.item_info("//3D view/view").rect_full
        pane.extend((box.min.x, box.min.y, box.max.x, box.max.y))

    driver.run(drive)
    assert not state.scene.processor_draws
    shot = np.asarray(hello_imgui.final_app_window_screenshot()).astype(int)
    left, top, right, bottom = (round(edge) for edge in pane)
    view = shot[top:bottom, left:right]
    middle = view[view.shape[0] // 2, view.shape[1] // 2]
    assert np.ptp(middle) == 0  # The model is grey,
    assert 60 < middle[0] < 140  # half as bright as white,
    beside = np.rint(255 * np.array(GREY))
    assert (view[view.shape[0] // 2, 2] == beside).all()  # and nothing is beside it.
    assert np.ptp(shot[:top]) > 200


@pytest.mark.display
def test_splats_alone_have_the_pictures_place_until_a_clip_comes(
    places: Places, model: DynamicGaussians, tmp_path: Path
) -> None:
    driver = Driver(places)
    file = tmp_path / "splats.ply"
    file.write_bytes(ply_bytes(model.raw, "default", []))
    actions.open_path(driver.state, file)
    heights: list[float] = []

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: driver.state.scene.view is not None, "the splats")
        ctx.yield_(3)
        box = ctx.item_info("//Splat file/view").rect_full
        heights.append(box.max.y - box.min.y)
        actions.open_path(driver.state, phantom_path())
        wait(ctx, lambda: is_settled(driver.state), "the phantom")
        ctx.yield_(3)
        ctx.item_click("//Images/**/###freeze")

    driver.run(drive)
    assert driver.state.timeline.frozen_index == 0
    assert heights[0] > 340
