from __future__ import annotations

import queue
import subprocess
import sys
import threading
from collections.abc import Iterator
from weakref import ref

import pytest

from app.errors import UserError
from app.gui.work import background
from app.gui.work.background import Channel, Failure, SteppedChannel, Worker

SECONDS = 5.0


def doubled(request: int) -> Iterator[int]:
    yield 2 * request


def test_an_answer_comes_once_with_its_request() -> None:
    channel = Channel(doubled)
    channel.ask(4)
    assert channel.run_waiting()
    assert channel.take() == (4, 8)
    assert channel.take() is None
    assert not channel.run_waiting()


def test_only_the_newest_request_is_done() -> None:
    done: list[int] = []

    def work(request: int) -> Iterator[int]:
        done.append(request)
        yield request

    channel = Channel(work)
    for request in range(5):
        channel.ask(request)
    while channel.run_waiting():
        pass
    assert done == [4]


def test_a_deep_channel_loses_nothing() -> None:
    channel = Channel(doubled, depth=4)
    for request in range(4):
        channel.ask(request)
    while channel.run_waiting():
        pass
    assert [channel.take() for _ in range(5)] == [(0, 0), (1, 2), (2, 4), (3, 6), None]


def test_better_answers_give_way_to_a_newer_request() -> None:
    channel: Channel[str, str]

    def work(request: str) -> Iterator[str]:
        yield f"{request} rough"
        if request == "old":
            channel.ask("new")
        yield f"{request} fine"
        raise AssertionError(f"{request} went on")

    channel = Channel(work)
    channel.ask("old")
    channel.run_waiting()
    assert channel.take() == ("old", "old fine")
    assert channel.asked == "new"


def test_nothing_wanted_keeps_nothing_alive() -> None:
    class Clip:
        """Something large."""

    channel: Channel[Clip, str] = Channel(lambda request: iter(["seen"]))
    clip = Clip()
    kept = ref(clip)
    channel.want(clip)
    channel.run_waiting()
    assert channel.take() == (clip, "seen")
    del clip
    assert kept() is not None
    channel.want(None)
    assert kept() is None


def test_the_window_may_go_on_while_what_is_given_up_is_cleared_away() -> None:
    free = list[bool]()

    def work(request: int) -> Iterator[int]:
        try:
            while True:
                yield request
        finally:
            window = threading.Thread(target=channel.take, daemon=True)
            window.start()
            window.join(0.5)
            free.append(not window.is_alive())

    channel = SteppedChannel(work)
    channel.ask(1)
    channel.run_waiting()
    channel.cancel()
    assert not channel.run_waiting()
    assert free == [True]


def test_what_cannot_be_cleared_away_stops_no_other_work() -> None:
    def work(request: int) -> Iterator[int]:
        try:
            while True:
                yield request
        finally:
            if request == 1:
                raise OSError("the drive is gone")

    channel = SteppedChannel(work)
    for request in (1, 2):
        channel.ask(request)
        channel.run_waiting()
        assert channel.take() == (request, request)
        channel.cancel()
    channel.run_waiting()
    channel.ask(1)
    channel.run_waiting()
    channel.close()


def test_an_exception_is_an_answer() -> None:
    def work(request: int) -> Iterator[int]:
        yield 1 // request

    channel = Channel(work)
    channel.ask(0)
    channel.run_waiting()
    taken = channel.take()
    assert taken is not None
    assert isinstance(taken[1], Failure)
    assert "zero" in taken[1].message


def test_an_exception_keeps_nothing_alive_that_led_to_it() -> None:
    class Frames:
        """Something large."""

    kept = list[ref[Frames]]()

    def read() -> None:
        frames = Frames()
        kept.append(ref(frames))
        raise ValueError("damaged")

    def work(request: int) -> Iterator[int]:
        try:
            read()
        except ValueError as error:
            raise UserError("expected a clip") from error
        yield request

    channel = Channel(work)
    channel.ask(0)
    channel.run_waiting()
    answer = channel.take()
    assert answer is not None
    assert isinstance(answer[1], Failure)
    assert kept[0]() is None


def test_the_worker_serves_in_its_own_thread_and_wakes_the_window() -> None:
    answered = threading.Event()
    threads: list[str] = []

    def work(request: int) -> Iterator[int]:
        threads.append(threading.current_thread().name)
        yield request

    channels = [Channel(work), Channel(work)]
    worker = Worker(channels, answered.set)
    for channel in channels:
        answered.clear()
        channel.ask(7)
        assert answered.wait(SECONDS)
        assert channel.take() == (7, 7)
    worker.close()
    assert set(threads) == {"vesselsplat-worker"}


def test_a_worker_rests_once_after_all_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """That is when memory goes back to the system."""
    monkeypatch.setattr(background, "REST", 0.05)
    rests = queue.SimpleQueue[str]()
    channel = Channel(lambda request: iter([request]))
    worker = Worker((channel,), lambda: None, lambda: rests.put(threading.current_thread().name))
    for request in range(2):
        channel.ask(request)
        assert rests.get(timeout=SECONDS) == "vesselsplat-worker"
        assert channel.take() == (request, request)
    worker.close()
    assert rests.empty()


def test_after_closing_no_other_work_is_begun() -> None:
    """The window's own thread does what must not be given up, and removes what the end makes useless."""
    begun, allowed, ended = threading.Event(), threading.Event(), threading.Event()
    done = list[str]()

    def long(request: int) -> Iterator[int]:
        begun.set()
        allowed.wait(SECONDS)
        yield request

    def late(request: int) -> Iterator[int]:
        done.append("late")
        yield request

    class Last(Channel[int, int]):
        def close(self) -> None:
            ended.set()

    first, second = Channel(long), Last(late)
    worker = Worker((first, second), lambda: None)
    first.ask(1)
    assert begun.wait(SECONDS)
    worker.close(timeout=0.01)
    second.ask(1)
    allowed.set()
    assert ended.wait(SECONDS)
    assert not done


def test_a_call_to_close_just_before_the_wake_up_is_cleared_is_heard() -> None:
    ended = threading.Event()

    class Last(Channel[int, int]):
        def close(self) -> None:
            ended.set()

    class Late(threading.Event):
        def clear(self) -> None:
            worker._closing.set()
            super().clear()

    channel = Last(doubled)
    worker = Worker((channel,), lambda: None)
    worker._wake = Late()
    worker._wake.set()
    channel.ask(1)  # Of the wake-up before, which the thread may wait for already.
    assert ended.wait(SECONDS)


def test_waiting_ends_with_the_last_answer_of_the_newest_request() -> None:
    allowed = threading.Event()

    def work(request: int) -> Iterator[str]:
        yield f"{request} rough"
        allowed.wait(SECONDS)
        yield f"{request} fine"

    channel = Channel(work)
    worker = Worker((channel,), lambda: None)
    channel.ask(1)
    channel.wait(0.05)
    taken = channel.take()
    assert taken is None or taken == (1, "1 rough")  # Given up: the fine one is not there yet.
    allowed.set()
    channel.wait(SECONDS)
    assert channel.take() == (1, "1 fine")
    worker.close()


@pytest.mark.parametrize(("seconds", "said"), [(0.0, "ended later\n"), (60.0, "ended ")])
def test_a_process_whose_worker_is_at_work_ends_at_once_and_well(seconds: float, said: str) -> None:
    """Python's own end aborts one whose thread is in OpenCV, as while a video is read."""
    code = f"""
import sys, time
import cv2, numpy as np
from app.gui.work.background import Channel, Worker, leave
image = np.zeros((2000, 2000, 3), np.uint8)

def work(request):
    end = time.monotonic() + {seconds}
    while time.monotonic() < end:
        cv2.GaussianBlur(image, (0, 0), 9)
    yield request

channel = Channel(work)
worker = Worker((channel,), lambda: None)
channel.ask(1)
channel.wait(1.0)
worker.close({30.0 if seconds == 0 else 0.1})
sys.stdout.write("ended ")
leave([worker])
print("later")
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stdout) == (0, said), done.stderr
