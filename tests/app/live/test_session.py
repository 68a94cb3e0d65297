"""A live session: the newest frame wins, nothing old looks live, a lost source comes back."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import cv2
import numpy as np
import pytest

from app.errors import UserError
from app.live.newest import Newest
from app.live.picture import LivePicture, LiveSetting
from app.live.session import LiveSession, is_black, rate_of
from app.live.sources.source import Arrived, Source, SourceLost
from enhance import EnhanceParams, enhance
from renderer.clip import ByteImage, ClipError
from tests.app.live.painted import PaintedSource, painted, wait_for

PLAIN = LiveSetting(None)


@contextmanager
def live(*sources: PaintedSource | Exception, setting: LiveSetting = PLAIN) -> Iterator[LiveSession]:
    """On one source after another; an exception is a try that finds none."""
    row = iter(sources)

    def opened() -> Source:
        one = next(row, SourceLost("nothing there"))
        if isinstance(one, Exception):
            raise one
        return one

    session = LiveSession(opened, setting)
    try:
        yield session
    finally:
        session.close()


def test_what_is_not_taken_gives_way_and_is_counted() -> None:
    newest: Newest[int] = Newest()
    for number in range(5):
        newest.put(number)
    assert newest.take() == 4
    assert newest.take() is None
    assert newest.dropped == 4


def test_every_frame_in_time_is_shown_and_the_end_is_told() -> None:
    seen = list[LivePicture]()
    with live(PaintedSource(range(20, 220, 20), pause=0.03)) as session:
        session.recipients = (seen.append,)
        wait_for(lambda: session.is_over, "the end")
        status = session.status()
    levels = [int(one.original[0, 0, 0]) for one in seen]
    assert levels == sorted(levels)
    assert len(seen) + status.dropped == status.arrived == 10
    assert status.dropped <= 1
    assert (status.signal, status.is_live) == ("ended", False)
    assert status.to_ready is not None
    assert 0 < status.to_ready.median < 1000


def test_the_last_frame_is_shown_also_where_it_comes_with_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    take, ended, waited = Newest[Arrived].take, threading.Event(), list[bool]()

    def in_vain_at_first(frames: Newest[Arrived], seconds: float = 0.0) -> Arrived | None:
        if waited:
            return take(frames, seconds)
        waited.append(ended.wait(10))
        return None

    monkeypatch.setattr(Newest, "take", in_vain_at_first)
    with live(PaintedSource([100], pause=0.1)) as session:
        wait_for(lambda: session.status().signal == "ended", "the last frame")
        ended.set()
        wait_for(lambda: session.is_over, "the end")
        assert session.status().made == 1


def test_a_slow_recipient_makes_frames_drop_and_none_queue() -> None:
    """What is shown is never older than the work in hand."""
    ages = list[float]()

    def slow(picture: LivePicture) -> None:
        ages.append(time.perf_counter() - picture.arrived)
        time.sleep(0.1)

    with live(PaintedSource([100] * 60, pause=0.01)) as session:
        session.recipients = (slow,)
        wait_for(lambda: session.is_over, "the end")
        assert session.status().dropped > 30
    assert max(ages) < 0.25


@pytest.mark.parametrize("now", [0.52, 1.0, 1.96, 2.0, 3.0, 9.0])
def test_the_rate_is_that_since_the_first_picture_where_that_is_less_than_the_window(now: float) -> None:
    times = [frame / 25 for frame in range(300) if frame / 25 <= now]
    assert rate_of(times, now) == pytest.approx(25, abs=0.6)
    assert rate_of(times, times[-1] + 5) < 25
    assert rate_of([], now) == rate_of([now], now) == 0


def test_a_setting_is_taken_over_with_the_next_frame() -> None:
    params = EnhanceParams(z=0.2, d_factor=0.0)
    with live(PaintedSource([120] * 200, pause=0.02), setting=PLAIN) as session:
        wait_for(lambda: session.status().made > 0, "white light")
        session.setting = LiveSetting(params, "all")
        found = list[LivePicture]()

        def has_changed() -> bool:
            if (one := session.pictures.take()) is not None and one.enhanced is not None:
                found.append(one)
            return bool(found)

        wait_for(has_changed, "the setting", 60)
    expected = enhance(painted(120), params, pixels="all").image
    assert found[0].setting.params == params
    assert np.array_equal(found[0].enhanced, expected)


@pytest.mark.parametrize("apart", [0.25, 0.5])
def test_statistics_follow_by_the_seconds_however_many_frames_are_left_out(apart: float) -> None:
    """A source of 100 frames a second, of which few are taken."""
    seen = list[LivePicture]()
    source = PaintedSource([100, 110, 110], pause=0.0, frames_per_second=100.0)
    read = source.read

    def later() -> Arrived | None:
        number = source._given
        wait_for(lambda: len(seen) == number, "the frame before", 60)
        arrived = read()
        return None if arrived is None else replace(arrived, at=1 + apart * number)

    source.read = later  # type: ignore[method-assign]
    session = LiveSession(lambda: source, LiveSetting(EnhanceParams(), "all"), recipients=(seen.append,))
    wait_for(lambda: session.is_over, "the end", 60)
    levels = [one.statistics.level for one in seen if one.statistics is not None]
    left = 0.5 ** (apart / 0.5)
    assert levels == pytest.approx([100, 110 - 10 * left, 110 - 10 * left**2], abs=0.01)


@pytest.mark.parametrize("error", [MemoryError("no memory"), cv2.error("no colours"), ClipError("no eyes")])
def test_a_frame_that_cannot_be_read_is_passed_over(error: Exception) -> None:
    def damaged() -> ByteImage:
        raise error

    source = PaintedSource([100] * 4, pause=0.1)
    read = source.read

    def once_damaged() -> Arrived | None:
        arrived = read()
        return replace(arrived, read=damaged) if arrived is not None and source._given == 2 else arrived

    source.read = once_damaged  # type: ignore[method-assign]
    with live(source) as session:
        wait_for(lambda: session.is_over, "the end")
        status = session.status()
    assert status.made + status.dropped >= 3


def test_silence_is_a_loss_with_its_reason() -> None:
    source = PaintedSource([100] * 5, then="wait")
    with live(source) as session:
        wait_for(lambda: session.status().signal == "lost", "the loss")
        assert session.status().reason in ("silent", "nothing there")
        assert session.status().times_lost == 1
        assert source.closed


def test_a_picture_gets_stale_in_half_a_second() -> None:
    hold = threading.Event()

    class Hanging(PaintedSource):
        def read(self):  # type: ignore[no-untyped-def]
            if self._given == len(self.levels):
                hold.wait(20)
            return super().read()

    with live(Hanging([100] * 5)) as session:
        wait_for(lambda: session.status().is_live, "pictures")
        wait_for(lambda: session.status().signal == "stale", "stale")
        now = session.status()
        hold.set()
    assert now.since is not None
    assert 0.5 < now.since < 0.6
    assert now.reason.startswith("no frame for 0.5")


def test_a_lost_source_comes_back_by_itself_in_another_size() -> None:
    first, second = PaintedSource([100] * 3, then="lose"), PaintedSource([90] * 200, size=(60, 80))
    with live(first, SourceLost("still unplugged"), second) as session:
        wait_for(lambda: session.status().signal == "lost", "the loss")
        wait_for(lambda: session.status().is_live, "its return")
        wait_for(lambda: _taken(session).shape == (60, 80, 3), "the other size")
        assert session.status().times_lost == 1


def _taken(session: LiveSession) -> ByteImage:
    picture = session.pictures.take()
    return np.empty(0, np.uint8) if picture is None else picture.original


def test_black_pictures_are_told() -> None:
    with live(PaintedSource([0] * 200)) as session:
        wait_for(lambda: session.status().signal == "black", "black")
        assert not session.status().is_live


@pytest.mark.parametrize(
    ("image", "black"),
    [
        (np.zeros((64, 64, 3), np.uint8), True),
        (np.full((64, 64, 3), 16, np.uint8), True),
        (painted(40, (64, 64)), False),
        (np.tile(np.arange(0, 24, dtype=np.uint8)[:, None, None], (4, 96, 3)), False),
    ],
    ids=["zero", "sixteen", "dark tissue", "a dark ramp"],
)
def test_black_is_what_grabbers_give_without_a_signal(image: ByteImage, black: bool) -> None:
    assert is_black(image) == black


def test_what_can_never_be_shown_ends_with_its_reason() -> None:
    with live(UserError("expected a video")) as session:
        wait_for(lambda: session.is_over, "the end")
        assert session.status().signal == "failed"
        assert session.status().reason == "expected a video"


def test_the_delay_to_the_screen_is_that_of_the_swap() -> None:
    with live(PaintedSource([100] * 100)) as session:
        wait_for(lambda: session.status().made > 1, "pictures")
        picture = session.pictures.take()
        assert picture is not None
        session.shown(picture, picture.arrived + 0.034)
        delay = session.status().to_screen
    assert delay is not None
    assert delay.median == pytest.approx(34)
