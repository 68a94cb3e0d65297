"""Several reconstructions: one at a time, in the order that was wished, each as it was chosen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from app.gui.actions import job_actions, queue_actions
from app.gui.panels.runs import draw_runs
from app.gui.state.app_state import AppState
from app.gui.update.update import Channels, update
from app.job import Cancelled, Failed
from app.training import TrainRequest
from renderer.gaussians import DynamicGaussians
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
    update(state, channels, state.now + 0.1)
    queue_actions.advance(state, jobs.make)


def queued(state: AppState, jobs: Jobs, *iterations: int) -> None:
    for count in iterations:
        state.reconstruction.config = replace(state.reconstruction.config, iterations=count)
        job_actions.start_reconstruction(state, jobs.make)


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
    assert state.queue == ()


def test_what_waits_is_as_it_was_chosen(state: AppState, jobs: Jobs) -> None:
    queued(state, jobs, 100, 200, 300)
    state.reconstruction.config = replace(state.reconstruction.config, iterations=7)
    assert [waiting.request.config.iterations for waiting in state.queue] == [200, 300]
    assert state.reconstruction.iterations == 100  # What is shown of the run is the run's,
    assert state.reconstruction.config.iterations == 7  # what is chosen stays chosen.
    jobs.all[0].inbox = [Cancelled()]
    frame(state, jobs, Channels())
    assert state.reconstruction.config.iterations == 7


def test_no_two_share_a_folder(state: AppState, jobs: Jobs) -> None:
    for _ in range(3):
        state.reconstruction.name = "same"
        job_actions.start_reconstruction(state, jobs.make)
    requests = [*jobs.requests, *(waiting.request for waiting in state.queue)]
    assert [request.run_path.name for request in requests] == ["same", "same-2", "same-3"]


def test_both_in_turn_are_two_that_differ_in_their_frames_alone(state: AppState, jobs: Jobs) -> None:
    state.reconstruction.input, state.reconstruction.name = "both in turn", "clip"
    job_actions.start_reconstruction(state, jobs.make)
    (first,), (waiting,) = jobs.requests, state.queue
    second = waiting.request
    assert (first.input, second.input) == ("original", "enhanced")
    assert (first.run_path.name, second.run_path.name) == ("clip-original", "clip-enhanced")
    assert replace(second, input=first.input, run_path=first.run_path) == first
    assert state.reconstruction.input == "both in turn"


def test_what_waits_can_be_moved_to_the_front_and_withdrawn(state: AppState, jobs: Jobs) -> None:
    queued(state, jobs, 100, 200, 300, 400)
    two, three, four = state.queue
    queue_actions.to_front(state, four)
    assert state.queue == (four, two, three)
    queue_actions.withdraw(state, two)
    queue_actions.to_front(state, two)  # Gone is gone.
    assert state.queue == (four, three)


def test_nothing_is_taken_from_under_the_hand_that_edits(
    state: AppState, jobs: Jobs, model: DynamicGaussians
) -> None:
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
    assert queue_actions.may_close(state)
    queued(state, jobs, 100, 200)
    assert not queue_actions.may_close(state)
    assert "1 more waits" in queue_actions.at_stake(state)
    queue_actions.answer_closing(state, close=False)
    assert not queue_actions.may_close(state)
    queue_actions.answer_closing(state, close=True)
    assert queue_actions.may_close(state)
    state.closing, state.queue, state.reconstruction.status = "no", (), "finished"
    assert queue_actions.may_close(state)


def test_the_list_of_what_waits_draws(ui: Ui, state: AppState, jobs: Jobs) -> None:
    ui.frame(lambda: draw_runs(state, FakeJob))
    queued(state, jobs, 100, 200, 300)
    ui.frame(lambda: draw_runs(state, FakeJob))
    state.editing.active, state.reconstruction.status = True, "finished"
    ui.frame(lambda: draw_runs(state, FakeJob))
