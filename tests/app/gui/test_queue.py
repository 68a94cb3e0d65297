"""Several reconstructions: one at a time, in the order that was wished, each as it was chosen."""

from __future__ import annotations

import errno
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from app.enhancement.image_mask import PictureMask
from app.gui.actions import actions, clip_actions, closing, job_actions, queue_actions
from app.gui.panels.runs import draw_runs
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.jobs import LONGEST_END, start_due
from app.gui.update.update import update
from app.gui.work.settings import Places, Settings
from app.runs.job import Cancelled, Failed
from app.runs.queue_file import queue_file
from app.runs.train_run import TrainRequest
from renderer.clip import Clip
from renderer.phantom import PhantomParams, write_phantom
from renderer.train.events import Finished, Started
from tests.app.gui.conftest import FakeJob, make_model
from tests.app.gui.ui import Ui


class Jobs:
    """All that were started, oldest first."""

    def __init__(self) -> None:
        self.all: list[FakeJob] = []

    def make(self, request: object) -> FakeJob:
        self.all.append(FakeJob(request))
        return self.all[-1]

    @property
    def requests(self) -> list[TrainRequest]:
        return [job.request for job in self.all if isinstance(job.request, TrainRequest)]


@pytest.fixture
def jobs() -> Jobs:
    return Jobs()


def frame(state: AppState, jobs: Jobs, channels: Channels) -> None:
    """As the window goes from one frame to the next."""
    update(state, channels, state.window.now + 0.1)
    start_due(state, jobs.make)


def queued(state: AppState, jobs: Jobs, *iterations: int) -> None:
    for count in iterations:
        state.runs.reconstruction.config = replace(state.runs.reconstruction.config, iterations=count)
        job_actions.start_reconstruction(state)
        start_due(state, jobs.make)


@pytest.mark.parametrize(
    "end", [lambda: Finished(20, 2.0, make_model()), Cancelled, lambda: Failed("out of memory")]
)
def test_the_next_starts_when_one_has_ended_and_never_before(
    state: AppState, jobs: Jobs, end: Callable[[], object]
) -> None:
    queued(state, jobs, 100, 200)
    channels = Channels()
    for events in ([Started(0, 100, 30, ())], []):
        jobs.all[0].inbox = events
        frame(state, jobs, channels)
        assert len(jobs.all) == 1
    jobs.all[0].inbox = [end()]
    frame(state, jobs, channels)
    assert [request.config.iterations for request in jobs.requests] == [100, 200]
    assert jobs.all[0].told == ["start", "close"]
    assert state.runs.queue == ()


def test_what_is_added_to_the_queue_is_said(state: AppState, jobs: Jobs) -> None:
    queued(state, jobs, 100)
    assert state.window.toast is None
    queued(state, jobs, 200)
    assert state.window.toast is not None
    (waiting,) = state.runs.queue
    assert state.window.toast.message == f"queued {waiting.request.run_path.name}: see Runs"


def test_a_process_that_takes_a_while_to_end_is_waited_for_by_the_next_and_not_by_the_window(
    state: AppState, jobs: Jobs
) -> None:
    queued(state, jobs, 100)
    channels, (first,) = Channels(), jobs.all
    first.has_gone, first.inbox = False, [Started(0, 100, 30, ()), Cancelled()]
    frame(state, jobs, channels)
    assert state.runs.reconstruction.status == "cancelled"
    queued(state, jobs, 200)
    frame(state, jobs, channels)
    assert (first.told, len(jobs.all)) == (["start"], 1)
    assert state.window.toast is not None
    assert state.window.toast.message.startswith("It starts as soon as")
    first.has_gone = True
    frame(state, jobs, channels)
    assert first.told == ["start", "close"]
    assert [request.config.iterations for request in jobs.requests] == [100, 200]


def test_a_process_that_never_ends_is_ended(state: AppState, jobs: Jobs) -> None:
    queued(state, jobs, 100)
    channels, (first,) = Channels(), jobs.all
    first.has_gone, first.inbox = False, [Started(0, 100, 30, ()), Cancelled()]
    frame(state, jobs, channels)
    state.window.now += LONGEST_END
    frame(state, jobs, channels)
    assert first.told == ["start", "close"]


def test_one_whose_mask_leaves_nothing_is_told_and_the_next_starts(state: AppState, jobs: Jobs) -> None:
    whole = state.source.part
    clip_actions.set_mask(state, PictureMask(text=(-1, -1, 1e4, 1e4)))
    job_actions.start_reconstruction(state)
    state.source.part = whole
    job_actions.start_reconstruction(state)
    start_due(state, jobs.make)
    assert jobs.all == []
    assert state.window.banner is not None
    assert "was not started: expected a mask that keeps some of the" in state.window.banner.message
    start_due(state, jobs.make)
    assert len(jobs.all) == 1


def test_one_whose_process_cannot_be_started_is_told_and_the_next_starts(state: AppState, jobs: Jobs) -> None:
    class Refused(FakeJob):
        def start(self) -> None:
            raise OSError(errno.ENOMEM, os.strerror(errno.ENOMEM))

    for _ in range(2):
        job_actions.start_reconstruction(state)
    start_due(state, Refused)
    assert state.window.banner is not None
    assert "was not started: Cannot allocate memory" in state.window.banner.message
    assert not state.runs.reconstruction.is_alive
    start_due(state, jobs.make)
    assert [job.told for job in jobs.all] == [["start"]]


def test_what_waits_is_as_it_was_chosen(state: AppState, jobs: Jobs) -> None:
    queued(state, jobs, 100, 200, 300)
    state.runs.reconstruction.config = replace(state.runs.reconstruction.config, iterations=7)
    assert [waiting.request.config.iterations for waiting in state.runs.queue] == [200, 300]
    assert state.runs.reconstruction.iterations == 100  # What is shown of the run is the run's,
    assert state.runs.reconstruction.config.iterations == 7  # what is chosen stays chosen.
    jobs.all[0].inbox = [Cancelled()]
    frame(state, jobs, Channels())
    assert state.runs.reconstruction.config.iterations == 7


def test_no_two_share_a_folder(state: AppState, jobs: Jobs) -> None:
    for _ in range(3):
        state.runs.reconstruction.name = "same"
        job_actions.start_reconstruction(state)
        start_due(state, jobs.make)
    requests = [*jobs.requests, *(waiting.request for waiting in state.runs.queue)]
    assert [request.run_path.name for request in requests] == ["same", "same-2", "same-3"]


def test_both_in_turn_are_two_that_differ_in_their_frames_alone(state: AppState, jobs: Jobs) -> None:
    state.runs.reconstruction.input, state.runs.reconstruction.name = "both in turn", "clip"
    job_actions.start_reconstruction(state)
    start_due(state, jobs.make)
    (first,), (waiting,) = jobs.requests, state.runs.queue
    second = waiting.request
    assert (first.input, second.input) == ("original", "enhanced")
    assert (first.run_path.name, second.run_path.name) == ("clip-original", "clip-enhanced")
    assert replace(second, input=first.input, run_path=first.run_path) == first
    assert state.runs.reconstruction.input == "both in turn"


def test_both_in_turn_differ_where_a_long_name_is_cut(state: AppState, jobs: Jobs) -> None:
    state.runs.reconstruction.input = "both in turn"
    job_actions.name_run(state, 100 * "é")
    job_actions.start_reconstruction(state)
    names = [waiting.request.run_path.name for waiting in state.runs.queue]
    assert [name.lstrip("é") for name in names] == ["-original", "-enhanced"]
    assert max(len(name.encode()) for name in names) <= 120


def test_what_waits_can_be_moved_to_the_front_and_withdrawn(state: AppState, jobs: Jobs) -> None:
    queued(state, jobs, 100, 200, 300, 400)
    two, three, four = state.runs.queue
    queue_actions.to_front(state, four)
    assert state.runs.queue == (four, two, three)
    queue_actions.withdraw(state, two)
    queue_actions.to_front(state, two)  # Gone is gone.
    assert state.runs.queue == (four, three)


def test_nothing_is_taken_from_under_the_hand_that_edits(state: AppState, jobs: Jobs) -> None:
    queued(state, jobs, 100, 200)
    state.editing.active = True
    jobs.all[0].inbox = [Cancelled()]
    frame(state, jobs, Channels())
    assert len(jobs.all) == 1
    assert queue_actions.why_held(state)
    state.editing.active = False
    frame(state, jobs, Channels())
    assert len(jobs.all) == 2


def test_closing_is_asked_about_exactly_while_something_would_be_lost(state: AppState, jobs: Jobs) -> None:
    assert closing.may_close(state)
    queued(state, jobs, 100, 200)
    assert not closing.may_close(state)
    assert "1 more is queued" in closing.at_stake(state)
    assert "next start" in closing.what_is_kept(state)
    state.runs.reconstruction.status = "paused"
    assert "is paused, and 1 more is queued" in closing.at_stake(state)
    state.runs.reconstruction.status = "running"
    closing.answer_closing(state, close=False)
    assert not closing.may_close(state)
    closing.answer_closing(state, close=True)
    assert closing.may_close(state)
    state.window.closing, state.runs.reconstruction.status = "no", "finished"
    assert closing.may_close(state)  # What waits is kept.
    actions.remember_recent(state, False)
    assert not closing.may_close(state)
    assert "discarded" in closing.what_is_kept(state)
    state.window.closing, state.runs.queue = "no", ()
    assert closing.may_close(state)


def test_the_list_of_what_waits_draws(ui: Ui, state: AppState, jobs: Jobs) -> None:
    ui.frame(lambda: draw_runs(state))
    queued(state, jobs, 100, 200, 300)
    ui.frame(lambda: draw_runs(state))
    state.editing.active, state.runs.reconstruction.status = True, "finished"
    ui.frame(lambda: draw_runs(state))


@pytest.fixture
def later(state: AppState, jobs: Jobs, places: Places, tmp_path: Path) -> AppState:
    """The next window, after one in which a job of 100 steps ran and three waited died."""
    clip_path = tmp_path / "real"
    write_phantom(clip_path, PhantomParams(n_frames=6, width=32, height=24), "endonerf")
    assert state.source.clip is not None
    state.source.clip = replace(state.source.clip, path=clip_path)
    queued(state, jobs, 100, 200, 300, 400)
    channels = Channels()
    frame(state, jobs, channels)
    while channels.kept.run_waiting():
        pass
    die(places)
    again = AppState(places, Settings(acknowledged=True))
    queue_actions.take_up(again)
    return again


def die(places: Places) -> None:
    """The file of this process is that of one that has ended."""
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    own = queue_file(places.config)
    own.rename(own.with_name(f"queue-{dead.pid}.json"))


def test_what_waits_is_there_after_a_restart_and_starts_at_a_word(
    state: AppState, later: AppState, jobs: Jobs
) -> None:
    before = [waiting.request for waiting in state.runs.queue]
    assert later.window.toast is not None
    assert later.window.toast.message.startswith("3 reconstructions are queued")
    assert [waiting.request for waiting in later.runs.queue] == before
    new, channels = Jobs(), Channels()
    for _ in range(3):
        frame(later, new, channels)
        assert not channels.clips.run_waiting()
    assert new.all == []  # Nobody has said so.
    queue_actions.wake(later)
    for _ in range(3):
        frame(later, new, channels)
        channels.clips.run_waiting()
    assert new.requests == before[:1]
    assert later.runs.reconstruction.clip is not None
    assert len(later.runs.reconstruction.clip) == 6
    assert [waiting.request for waiting in later.runs.queue] == before[1:]


def test_what_is_asked_for_now_goes_before_what_sleeps(later: AppState, clip: Clip) -> None:
    new = Jobs()
    later.source.clip = clip
    job_actions.start_reconstruction(later)
    start_due(later, new.make)
    job_actions.start_reconstruction(later)
    start_due(later, new.make)
    assert len(new.all) == 1
    assert [waiting.asleep for waiting in later.runs.queue] == [False, True, True, True]
    new.all[0].inbox = [Cancelled()]
    frame(later, new, channels := Channels())
    new.all[1].inbox = [Cancelled()]
    frame(later, new, channels)
    frame(later, new, channels)
    assert len(new.all) == 2  # The others sleep on.
    four = later.runs.queue[-1]
    queue_actions.to_front(later, four)  # A word for this one alone.
    for _ in range(3):
        frame(later, new, channels)
        channels.clips.run_waiting()
    assert new.requests[2:] == [four.request]
    assert all(waiting.asleep for waiting in later.runs.queue)


def test_without_its_clip_one_waits_on_and_says_so(later: AppState) -> None:
    shutil.rmtree(later.runs.queue[0].request.clip_path)
    queue_actions.wake(later)
    new, channels = Jobs(), Channels()
    for _ in range(3):
        frame(later, new, channels)
        channels.clips.run_waiting()
    assert later.window.banner is not None
    assert "real" in later.window.banner.message
    assert new.all == []
    assert len(later.runs.queue) == 3
    assert later.runs.queue[0].asleep


def test_a_damaged_file_gives_what_can_be_read_and_is_kept(
    state: AppState, jobs: Jobs, places: Places
) -> None:
    queued(state, jobs, 100, 200, 300)
    queue_actions.keep_now(state)
    own = queue_file(places.config)
    told = json.loads(own.read_text())
    told[0]["config"]["iterations"] = -1
    own.write_text(json.dumps(told))
    die(places)
    again = AppState(places, Settings(acknowledged=True))
    queue_actions.take_up(again)
    assert [waiting.request for waiting in again.runs.queue] == [state.runs.queue[1].request]
    assert again.window.banner is not None
    assert ".broken" in again.window.banner.message
    assert len(list(places.config.glob("*.broken"))) == 1
    third = AppState(places, Settings(acknowledged=True))
    queue_actions.take_up(third)
    assert third.runs.queue == ()  # They are the other window's, which lives.


def test_an_empty_queue_leaves_no_file_and_nothing_is_kept_where_paths_are_not_remembered(
    state: AppState, jobs: Jobs, places: Places
) -> None:
    queued(state, jobs, 100, 200)
    queue_actions.keep_now(state)
    assert queue_file(places.config).exists()
    actions.remember_recent(state, False)
    queue_actions.keep_now(state)
    assert not queue_file(places.config).exists()
