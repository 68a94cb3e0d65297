"""The whole window saved as a picture: what is on the screen, without the panel that asked for it."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from imgui_bundle import hello_imgui, imgui

from app.exports.exporting import export
from app.files.image_files import read_image
from app.files.provenance import read_provenance
from app.gui.actions import export_actions, window_actions
from app.gui.commands.keys import chord
from app.gui.state.app_state import AppState
from app.gui.work.settings import Places
from assets import phantom_path
from tests.app.conftest import Cli
from tests.app.gui.driver import Driver, is_settled, wait


def test_the_frame_is_taken_once_what_was_clicked_has_gone(state: AppState) -> None:
    assert not window_actions.is_due(state)
    export_actions.save_window(state)
    assert state.is_busy
    due = [window_actions.is_due(state) for _ in range(6)]
    assert due.count(True) == 1
    assert due.index(True) >= 1
    assert not state.exports.is_busy


def test_it_says_what_was_seen_and_that_it_cannot_be_made_again(state: AppState, vesselsplat: Cli) -> None:
    assert state.source.clip is not None
    state.source.clip.path.mkdir()
    image = np.random.default_rng(0).integers(0, 255, (30, 40, 3), np.uint8)
    (step,) = export(window_actions.window_request(state, image))
    assert step.path is not None
    np.testing.assert_array_equal(read_image(step.path), image)
    facts = read_provenance(step.path)
    assert (facts["kind"], facts["frame"]["index"]) == ("window", 0)
    assert [pane["shows"] for pane in facts["panes"]] == ["original", "setting"]
    call = vesselsplat("replay", step.path)
    assert (call.code, call.out, call.error.count("\n")) == (2, "", 1)
    assert "the whole window" in call.error


def test_nothing_open_is_a_window_too(places: Places) -> None:
    request = window_actions.window_request(AppState(places), np.zeros((2, 2, 3), np.uint8))
    (step,) = export(request)
    assert step.path is not None
    assert step.path.name.startswith("vesselsplat-window")


@pytest.mark.display
def test_the_picture_is_the_screen_without_the_export_panel(places: Places) -> None:
    driver = Driver(places, opens=phantom_path())
    state = driver.state

    def shots() -> list[Path]:
        return sorted(
            places.pictures.glob("phantom-frame-1-window*.png"), key=lambda path: path.stat().st_mtime_ns
        )

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        wait(ctx, lambda: state.timeline.strip is not None, "the small frames")
        wait(ctx, lambda: state.picture.measured is not None, "the measures")
        ctx.key_press(chord("Ctrl+Shift+E"))
        ctx.yield_(2)
        ctx.item_click("//Export/**/###window")
        ctx.item_click("//Export/**/###start")
        wait(ctx, lambda: len(shots()) == 1, "the first picture")
        ctx.yield_(3)
        ctx.item_click("//Export/#CLOSE")
        state.window.toast = None
        ctx.mouse_move("//Images/left")
        ctx.yield_(3)
        ctx.key_press(imgui.Key.f12)
        wait(ctx, lambda: len(shots()) == 2, "the second picture")
        wait(ctx, lambda: state.window.toast is not None, "the word that it is there")
        state.window.toast = None
        ctx.yield_(3)

    driver.run(drive)
    assert not state.exports.shown
    first, second = (cv2.imread(str(path)).astype(int) for path in shots())
    last = np.asarray(hello_imgui.final_app_window_screenshot())[..., ::-1].astype(int)
    assert second.shape == last.shape
    # Upright, and all of it.
    assert (np.abs(second - last).max(axis=2) > 8).mean() < 0.01
    # The mouse was elsewhere; the panel would cover a third.
    assert (np.abs(first - last).max(axis=2) > 8).mean() < 0.15
