"""A calibration that is chosen for the open clip: undistorted, remembered, and removed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui
from PIL import Image

from app.enhancement.settable import RENDER
from app.gui.actions import arriving, browse_actions, clip_actions, live_actions, run_actions
from app.gui.panels import reconstruction
from app.gui.state import panes
from app.gui.state.app_state import AppState
from app.gui.state.source import Source
from app.gui.work.opening import OpenRequest, open_path
from app.gui.work.settings import Places, load_clips
from renderer.readers.clip_options import ClipOptions
from renderer.readers.lenses.calibration import Calibration, FoundLens
from tests.app.gui.driver import Driver, is_settled, wait
from tests.app.gui.settling import keep_all
from tests.app.gui.test_reconstruction_choices import opened, to_choices, turn
from tests.app.gui.test_runs import named
from tests.app.gui.ui import Ui
from tests.renderer.raw_eyes import EYES, raw_pairs, write_calibration
from tests.renderer.readers.numbered import encoded


@pytest.fixture(scope="module")
def pair() -> tuple[np.ndarray, np.ndarray]:
    return raw_pairs(1)[0]


@pytest.fixture
def video(tmp_path: Path, pair: tuple[np.ndarray, np.ndarray]) -> Path:
    return encoded(tmp_path / "a.mp4", 3 * [np.hstack(pair)])


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return write_calibration(tmp_path / "eyes.json")


def test_a_calibration_gives_depth_in_mm_is_there_the_next_time_and_can_be_removed(
    places: Places, video: Path, file: Path
) -> None:
    state, channels = opened(places, video)
    clip_actions.choose_eyes(state, "side-by-side")
    turn(state, channels)
    assert state.source.clip is not None
    before = state.source.clip.read_image(0)
    clip_actions.choose_calibration(state, file)
    turn(state, channels)
    assert state.source.clip.calibrated
    assert (state.source.clip.unit, state.source.clip.depth_origin) == ("mm", "stereo")
    assert state.source.options.calibration == EYES
    clip_actions.keep_settings(state)
    keep_all(state)
    file.unlink()  # Its numbers are remembered, not where it lay.
    again, channels = opened(places, video, Source(known=load_clips(places.config)))
    assert again.source.clip is not None
    assert again.source.clip.calibrated
    assert again.source.options.stereo == "side-by-side"
    clip_actions.drop_calibration(again)
    turn(again, channels)
    assert not again.source.clip.calibrated
    np.testing.assert_array_equal(again.source.clip.read_image(0), before)
    assert again.source.known[str(video)].calibration is None
    assert again.source.known[str(video)].stereo == "side-by-side"


def test_a_live_source_that_is_waited_for_gives_way_to_the_calibrated_clip(
    places: Places, video: Path, file: Path
) -> None:
    state, _ = opened(places, video)
    live_actions.play_file(state, video)
    assert state.live.connects
    clip_actions.choose_calibration(state, file)
    assert state.source.opening is not None
    assert not state.live.connects


def test_one_that_does_not_fit_is_refused_and_the_clip_stays(places: Places, video: Path, file: Path) -> None:
    state, channels = opened(places, video)
    clip_actions.choose_calibration(state, file)
    turn(state, channels)
    assert state.window.banner is not None
    assert "--stereo side-by-side" in state.window.banner.message
    assert state.source.clip is not None
    assert not state.source.clip.calibrated
    assert str(video) not in state.source.known


def test_one_of_the_start_that_does_not_fit_is_said_and_the_clip_opens(places: Places, video: Path) -> None:
    state, _ = opened(places, video, Source(ClipOptions(calibration=EYES)))
    assert state.source.clip is not None
    assert not state.source.clip.calibrated
    assert state.window.banner is not None
    assert "opened without the calibration" in state.window.banner.message


def test_a_lens_that_training_found_is_not_remembered_as_chosen(places: Places, video: Path) -> None:
    state, _ = opened(places, video)
    found = Calibration(lens=EYES.lens, found=FoundLens(deviation=0.01))
    clip_actions.keep_reading(state, replace(state.source.options, depth="motion", calibration=found))
    known = state.source.known[str(video)]
    assert (known.depth, known.calibration) == ("motion", None)


def test_a_run_on_undistorted_images_is_compared_with_these_alone_and_can_be_opened_for_them(
    state: AppState, runs: dict[str, Path], ui: Ui, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While it is trained the clip is open as its files are."""
    path = runs["original"]
    state.places = replace(state.places, runs=path.parent)
    (answer,) = open_path(OpenRequest(path))
    arriving.show_opened(state, path, answer)
    run, scene = named(state, path.name), state.scene.model
    assert scene is not None
    assert scene.record.clip is not None
    assert panes.why_not(state, RENDER) == ""
    assert run_actions.is_as_it_is(state, run)
    found = Calibration(lens=EYES.lens, found=FoundLens(deviation=0.01))
    cameras = tuple(replace(camera, fx=1.1 * camera.fx) for camera in scene.cameras)
    record = replace(scene.record, clip=replace(scene.record.clip, calibration=found))
    state.scene.model = replace(scene, cameras=cameras, record=record)
    assert panes.why_not(state, RENDER).startswith("Its images are undistorted otherwise")
    assert not run_actions.is_as_it_is(state, run)
    said = list[str]()
    monkeypatch.setattr(reconstruction, "button", lambda label, act=None, *_, **__: said.append(label))
    ui.frame(lambda: reconstruction.draw_reconstruction(state))
    assert "Open with undistorted frames" in said
    run_actions.open_again(state)
    assert state.source.opening is not None
    assert state.source.opening.path == path
    state.source.options = replace(state.source.options, calibration=found)
    assert panes.why_not(state, RENDER) == ""
    said.clear()
    ui.frame(lambda: reconstruction.draw_reconstruction(state))
    assert "Reconstruct###start" in said
    assert "Open with undistorted frames" not in said


@pytest.mark.display
def test_it_is_chosen_and_removed_by_hand(
    places: Places, tmp_path: Path, pair: tuple[np.ndarray, np.ndarray], file: Path
) -> None:
    (tmp_path / "clip").mkdir()
    for at in range(3):
        Image.fromarray(pair[0]).save(tmp_path / "clip" / f"{at}.png")
    driver = Driver(places, opens=tmp_path / "clip")
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state) and state.source.depth_ways is not None, "the clip")
        to_choices(ctx)
        ctx.item_click("Calibration…")
        wait(ctx, lambda: state.window.browsing is not None, "a dialog")
        assert state.window.browsing is not None
        assert state.window.browsing.choosing.purpose == "calibration"
        browse_actions.chosen(state, state.window.browsing.choosing, file)
        state.window.browsing = None
        wait(ctx, lambda: state.source.clip is not None and state.source.clip.calibrated, "its calibration")
        ctx.yield_(2)
        ctx.item_click("###remove lens")
        wait(ctx, lambda: state.source.clip is not None and not state.source.clip.calibrated, "none")
        state.window.closing = "agreed"

    driver.run(drive)
    assert state.source.known[str(tmp_path / "clip")].calibration is None
