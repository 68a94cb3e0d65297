"""A video whose frames hold both eyes and that does not say so: chosen in the window."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.gui.actions import clip_actions, depth_actions
from app.gui.state.source import Source
from app.gui.work.settings import Places, load_clips
from renderer.readers.clip_options import ClipOptions
from tests.app.gui.driver import Driver, is_settled, wait
from tests.app.gui.settling import keep_all
from tests.app.gui.test_reconstruction_choices import opened, to_choices, turn
from tests.renderer.eyes import look
from tests.renderer.readers.numbered import encoded


@pytest.fixture
def video(tmp_path: Path) -> Path:
    eyes = look(0, width=128, height=96, seed=41, noise=0.5, n_frames=1)
    return encoded(tmp_path / "a.mp4", 3 * [np.concatenate((eyes.left.image, eyes.right.image), axis=1)])


def test_the_choice_splits_the_frames_and_is_there_the_next_time(places: Places, video: Path) -> None:
    state, channels = opened(places, video)
    assert state.source.clip is not None
    assert state.source.clip.size == (256, 96)
    assert any("look alike" in notice for notice in state.source.notices)
    clip_actions.choose_eyes(state, "side-by-side")
    turn(state, channels)
    assert state.source.clip.size == (128, 96)
    assert (state.source.options.stereo, state.source.clip.depth_origin) == ("side-by-side", "stereo")
    clip_actions.keep_settings(state)  # What is kept besides leaves it.
    keep_all(state)
    again, channels = opened(places, video, Source(known=load_clips(places.config)))
    assert again.source.options.stereo == "side-by-side"
    said, _ = opened(places, video, Source(ClipOptions(stereo="off"), known=load_clips(places.config)))
    assert said.source.options.stereo == "off"  # A flag goes before what was chosen.
    clip_actions.choose_eyes(again, "auto")
    turn(again, channels)
    assert again.source.clip is not None
    assert again.source.clip.size == (256, 96)
    assert again.source.known[str(video)].stereo == "auto"


def test_a_video_that_cannot_be_split_stays_open_and_can_be_opened_again(
    places: Places, tmp_path: Path
) -> None:
    odd = encoded(tmp_path / "a.mkv", [np.full((64, 97, 3), 90, np.uint8)], "ffv1", pixels="bgr0")
    state, channels = opened(places, odd)
    clip_actions.choose_eyes(state, "side-by-side")
    turn(state, channels)
    assert state.window.banner is not None
    assert "expected an even width of side-by-side stereo, got 97x64" in state.window.banner.message
    assert state.source.clip is not None
    assert (state.source.clip.size, state.source.options.stereo) == ((97, 64), "auto")
    assert str(odd) not in state.source.known


@pytest.mark.display
def test_it_is_chosen_by_hand(places: Places, video: Path) -> None:
    driver = Driver(places, opens=video)
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state) and state.source.depth_ways is not None, "the video")
        to_choices(ctx)
        ctx.combo_click("##Stereo video/Left and right halves")
        wait(ctx, lambda: state.source.options.stereo == "side-by-side", "both eyes")
        wait(ctx, lambda: depth_actions.without_scale(state) != "", "depth")
        state.window.closing = "agreed"

    driver.run(drive)
    assert state.source.clip is not None
    assert state.source.clip.size == (128, 96)
