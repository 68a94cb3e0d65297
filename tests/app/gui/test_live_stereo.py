"""A stereo live source in the window: its eyes chosen, the left one in its true shape, its measures shown."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import cv2
import pytest
from imgui_bundle import imgui

from app.gui.actions import live_actions
from app.gui.commands.keys import chord
from app.gui.state.app_state import AppState
from app.gui.state.live_words import counts, delay_text
from app.gui.update.live import end_live, follow_live
from app.gui.work.settings import Places, Settings
from app.live.address import LiveInput, address_of
from app.live.picture import LiveSetting, LiveStatus
from app.live.session import LiveSession
from app.live.sources.both_eyes import BothEyesSource
from app.live.sources.source import Source, Wish
from renderer.sources import open_bare
from tests.app.gui.driver import Driver, wait
from tests.app.live.painted import PaintedSource, painted

Context = imgui.test_engine.TestContext


def follow(state: AppState, source: Callable[[], Source], name: str) -> None:
    """Go live on it, until it is shown."""
    live_actions.go_live(state, LiveInput(address_of(name)), Wish())
    end = time.monotonic() + 10
    while state.source.clip is None or state.source.clip.name != f"device {name}":
        assert time.monotonic() < end
        follow_live(state, lambda _, setting: LiveSession(source, LiveSetting(None)))
        time.sleep(0.01)


def test_a_squeezed_eye_is_shown_in_its_true_shape_and_the_next_source_in_its_own(places: Places) -> None:
    state = AppState(places, Settings(acknowledged=True))
    squeezed = PaintedSource([90] * 200, size=(60, 80))
    follow(state, lambda: BothEyesSource(squeezed, "side-by-side"), "1")
    assert state.source.clip is not None
    assert (state.source.clip.size, state.picture.view.pixel_aspect) == ((40, 60), 2.0)
    follow(state, lambda: PaintedSource([90] * 200, pause=0.05), "2")
    assert state.source.clip.size == (64, 48), "the first frame is of the source whose name it has"
    assert state.picture.view.pixel_aspect == 1.0
    end_live(state)


def film(path: Path, level: int) -> Path:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 25.0, (64, 48))
    for _ in range(25):
        writer.write(painted(level))
    writer.release()
    return path


@pytest.mark.display
def test_two_sources_are_chosen_in_the_dialog_and_recorded_with_both_eyes(
    places: Places, tmp_path: Path
) -> None:
    left, right = film(tmp_path / "left.avi", 200), film(tmp_path / "right.avi", 90)
    driver = Driver(places)
    state = driver.state

    def drive(ctx: Context) -> None:
        ctx.key_press(chord("Ctrl+L"))
        wait(ctx, lambda: state.live.choice.found is not None, "the list of devices")
        ctx.set_ref("//Open live source")
        ctx.combo_click("##Eyes/from two sources")
        ctx.yield_(2)
        assert state.live.choice.eyes == "two"
        ctx.item_click("//Open live source/##address")
        ctx.key_chars_replace_enter(str(left))
        assert state.live.choice.trouble.startswith("right eye: expected")
        ctx.item_click("//Open live source/##right")
        ctx.key_chars_replace(str(right))
        ctx.item_click("//Open live source/###typed")
        wait(ctx, lambda: state.live.flows, "pairs")
        wait(ctx, lambda: "eyes" in counts(state.live, _status(state)), "the time between them")
        assert "From eye to eye" in delay_text(_status(state))
        ctx.key_press(chord("Ctrl+Shift+L"))
        wait(
            ctx, lambda: state.live.recording is not None and state.live.recording.pictures > 3, "a recording"
        )
        ctx.key_press(chord("Ctrl+Shift+L"))
        wait(ctx, lambda: state.live.recorder is None, "its end")

    driver.run(drive)
    (made,) = places.pictures.glob("live-*-original.mp4")
    clip = open_bare(made)
    assert clip.size == (64, 48)
    assert clip.read_right is not None
    levels = clip.read_image(0)[4, 30, 0], clip.read_right(0)[4, 30, 0]
    # OpenCV writes blue first.
    assert levels == pytest.approx((200 // 3, 90 // 3), abs=4)


def _status(state: AppState) -> LiveStatus:
    assert state.live.status is not None
    return state.live.status
