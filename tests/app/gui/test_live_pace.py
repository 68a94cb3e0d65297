"""The window never waits for a source or a file, and waits for a picture where that brings it sooner."""

from __future__ import annotations

import time
from dataclasses import dataclass

import pytest

from app.gui.actions import actions, arriving, live_actions
from app.gui.state.app_state import AppState
from app.gui.state.live import Drawing, Live
from app.gui.state.live_words import live_tags
from app.gui.update.live import follow_live
from app.gui.update.live_pace import LONGEST, wait_for_picture
from app.gui.work.opening import Opened
from app.gui.work.settings import Places, Settings
from app.live.address import LiveAddress, LiveInput
from app.live.picture import LivePicture, LiveSetting, LiveStatus
from app.live.recorder import Recorder
from app.live.session import LiveSession
from app.live.sources.source import Wish
from renderer.clip import Clip
from tests.app.gui.test_live import PHANTOM
from tests.app.live.painted import PaintedSource, painted, wait_for

ARRIVED, INTERVAL = 100.0, 1 / 25


def live_at(rate: float, drawing: float) -> Live:
    """With a picture that arrived at ARRIVED."""
    picture = LivePicture(1, ARRIVED, painted(9), None, LiveSetting(None), None, (), 0.0)
    status = LiveStatus("live", "", "", rate, 1, 1, 0, 0, 0.0, None, None)
    live = Live(newest=picture, status=status, drawing=Drawing(seconds=drawing))
    live.session = live.clip = object()  # type: ignore[assignment]
    return live


@pytest.mark.parametrize(
    ("rate", "drawing", "passed", "wait"),
    [
        (25.0, 0.002, 0.013, 0.0),  # a graphics card is done long before the next one
        (25.0, 0.020, 0.013, INTERVAL - 0.013 + INTERVAL),  # done in time, with nothing to spare
        (25.0, 0.020, 0.005, 0.0),
        (25.0, 0.002, 0.060, INTERVAL),  # it is overdue
        (2.0, 0.300, 0.100, LONGEST),  # a slow source does not make the window slow
        (0.0, 0.020, 0.013, 0.0),
    ],
)
def test_a_frame_waits_for_the_picture_that_it_would_hold_up(
    rate: float, drawing: float, passed: float, wait: float
) -> None:
    assert wait_for_picture(live_at(rate, drawing), ARRIVED + passed) == pytest.approx(wait)


def test_a_frozen_picture_is_not_waited_for() -> None:
    live = live_at(25.0, 0.02)
    live.still = live.clip
    assert wait_for_picture(live, ARRIVED + 0.02) == 0.0


@dataclass
class SlowToClose(PaintedSource):
    """As a driver that hangs."""

    def close(self) -> None:
        time.sleep(2.0)
        super().close()


def test_leaving_waits_neither_for_the_source_nor_for_the_recording(places: Places) -> None:
    state, source = AppState(places, Settings(acknowledged=True)), SlowToClose(range(20, 200), then="wait")
    state.live.session = LiveSession(lambda: source, LiveSetting(None))
    state.live.source = LiveInput(LiveAddress("file", "", PHANTOM.name))
    recorder = Recorder(places.pictures / "a.mp4", "original", "a source")
    state.live.recorder, state.live.session.recipients = recorder, (recorder.add,)
    wait_for(lambda: recorder.state.pictures > 3, "a recording")
    state.live.leaving = True
    began = time.monotonic()
    follow_live(state, LiveSession)
    assert time.monotonic() - began < 1.0
    assert not source.closed
    assert state.live.session is None

    def completed() -> bool:
        follow_live(state, LiveSession)
        return not state.live.completing

    wait_for(completed, "the end of the recording")
    assert state.exports.last == recorder.state.path
    assert not recorder.state.trouble


def test_what_is_opened_ends_a_connection_that_has_given_nothing(state: AppState, clip: Clip) -> None:
    silent = PaintedSource((), then="wait")
    for begun in (False, True):
        live_actions.go_live(state, PHANTOM, Wish())
        if begun:
            follow_live(state, lambda _, setting: LiveSession(lambda: silent, setting))
        assert state.live.connects
        actions.open_path(state, clip.path)
        arriving.show_opened(state, clip.path, Opened(clip))
        follow_live(state, LiveSession)
        assert state.live.session is None
        assert not state.live.connects
        assert not live_tags(state.live)
