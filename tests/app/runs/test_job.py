"""The training job: what it tells, what it obeys, and that nothing of it stays behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.shared_memory import SharedMemory
from pathlib import Path

import numpy as np
import psutil
import pytest

from app.runs.job import Cancelled, Failed, JobEvent, Paused, Resumed, TrainingJob
from app.runs.train_run import TrainRequest
from app.runs.worker import Steps
from renderer.gaussians import DynamicGaussians
from renderer.train.config import TrainConfig
from renderer.train.events import Finished, Preparing, Progress, Started, Warned
from tests.app import fake_steps

PATIENCE = 30.0
"""Seconds that a spawned process may take on a busy machine."""


@contextmanager
def job_of(steps: Steps, tmp_path: Path) -> Iterator[TrainingJob]:
    request = TrainRequest(clip_path=tmp_path, run_path=tmp_path / "run", config=TrainConfig())
    job = TrainingJob(request, steps)
    job.start()
    try:
        yield job
    finally:
        job.close()


def events_until(job: TrainingJob, wanted: Callable[[JobEvent], bool]) -> list[JobEvent]:
    """All events up to the first that is wanted."""
    events: list[JobEvent] = []
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        events += job.poll()
        if any(wanted(event) for event in events):
            return events
        time.sleep(0.01)
    raise AssertionError(f"nothing wanted came, only {events}")


def is_a(*kinds: type) -> Callable[[JobEvent], bool]:
    return lambda event: isinstance(event, kinds)


def blocks_of(job: TrainingJob) -> list[str]:
    """Names of the job's shared memory blocks that exist."""
    slot = job._reader.slot
    found = []
    for generation in range(1, 10):
        try:
            SharedMemory(slot.block_name(generation)).close()
            found.append(slot.block_name(generation))
        except FileNotFoundError:
            continue
    return found


def test_a_run_tells_its_events_in_order_and_ends_with_the_model(tmp_path: Path) -> None:
    with job_of(fake_steps.growing, tmp_path) as job:
        events = events_until(job, is_a(Finished))
        assert [type(event) for event in events] == [Started, *[Progress] * 4, Finished]
        finished = events[-1]
        assert isinstance(finished, Finished)
        assert (finished.iteration, finished.seconds, len(finished.model)) == (4, 1.5, 7)
        assert job.state == "finished"
        # The newest snapshot outlives its process, whatever sizes came before it.
        newest = job.latest_model()
        assert newest is not None
        expected = fake_steps.model_of(20).arrays()
        assert all(np.array_equal(newest.arrays()[name], array) for name, array in expected.items())
        assert job.latest_model() is newest
        assert len(blocks_of(job)) == 1
    assert blocks_of(job) == []


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere blocks that are made have their room")
def test_training_goes_on_without_a_preview_that_has_no_room_and_says_so_once(tmp_path: Path) -> None:
    with job_of(fake_steps.without_room, tmp_path) as job:
        events = events_until(job, is_a(Finished, Failed))
        assert [type(event) for event in events] == [Started, Warned, *[Progress] * 4, Finished]
        assert (
            "No space left on device" in next(event for event in events if isinstance(event, Warned)).message
        )
        newest = job.latest_model()
        assert newest is not None
        assert len(newest) == 11
        assert len(blocks_of(job)) == 1
    assert blocks_of(job) == []


def test_what_comes_before_the_start_is_told(tmp_path: Path) -> None:
    with job_of(fake_steps.preparing, tmp_path) as job:
        events = events_until(job, is_a(Started))
        assert events[0] == Preparing("matching left and right images", 3, 27, 2.0, 16.0)
        assert isinstance(events[1], Started)


def test_pause_stops_the_flow_and_resume_continues_it(tmp_path: Path) -> None:
    with job_of(fake_steps.endless, tmp_path) as job:
        events_until(job, is_a(Progress))
        job.pause()
        events_until(job, is_a(Paused))
        assert job.state == "paused"
        time.sleep(0.3)
        assert job.poll() == []
        job.resume()
        events = events_until(job, is_a(Progress))
        assert isinstance(events[0], Resumed)
        assert job.state == "running"


def test_words_that_change_nothing_are_not_answered(tmp_path: Path) -> None:
    with job_of(fake_steps.endless, tmp_path) as job:
        events_until(job, is_a(Progress))
        job.resume()
        job.pause()
        job.pause()
        events_until(job, is_a(Paused))
        time.sleep(0.2)
        assert job.poll() == []


@pytest.mark.parametrize("paused", [False, True])
def test_cancel_closes_the_steps(tmp_path: Path, paused: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    with job_of(fake_steps.endless, tmp_path) as job:
        events_until(job, is_a(Progress))
        if paused:
            job.pause()
            events_until(job, is_a(Paused))
        job.cancel()
        events_until(job, is_a(Cancelled))
        assert job.state == "cancelled"
        assert (tmp_path / "run" / "closed").exists()
        end = time.monotonic() + PATIENCE
        while not job.has_gone and time.monotonic() < end:
            time.sleep(0.01)
        assert job.has_gone
        monkeypatch.setattr(job, "_say", said.append)
    assert said == []  # Its end of the pipe may be closed.


@pytest.mark.parametrize(
    ("steps", "reason", "has_details"),
    [
        (fake_steps.mistaken, "expected better, got this", False),
        (fake_steps.broken, "ZeroDivisionError: a bug", True),
        (fake_steps.cut_off, "EOFError: no more data", True),
        (fake_steps.killed, "SIGKILL", False),
        pytest.param(
            fake_steps.killed_without_a_name,
            "killed by signal 40;",
            False,
            marks=pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is no such signal"),
        ),
        (fake_steps.exited, "exit code 3", False),
    ],
)
def test_a_run_that_dies_says_why_once(tmp_path: Path, steps: Steps, reason: str, has_details: bool) -> None:
    with job_of(steps, tmp_path) as job:
        failures = [event for event in events_until(job, is_a(Failed)) if isinstance(event, Failed)]
        assert job.state == "failed"
        assert reason in failures[0].reason
        assert "is kept" not in failures[0].reason  # There is no checkpoint.
        assert ("Traceback" in failures[0].details) == has_details
        time.sleep(0.1)
        assert job.poll() == []
        for obey in (job.pause, job.resume, job.cancel):
            obey()  # to a process that is gone
    assert blocks_of(job) == []


def test_a_model_that_finds_no_memory_is_a_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(path: Path) -> None:
        raise MemoryError

    monkeypatch.setattr(DynamicGaussians, "load", full)
    with job_of(fake_steps.growing, tmp_path) as job:
        assert events_until(job, is_a(Failed))[-1] == Failed("MemoryError")


def test_close_ends_a_running_process_and_frees_its_memory(tmp_path: Path) -> None:
    with job_of(fake_steps.snapshot_then_endless, tmp_path) as job:
        events_until(job, is_a(Progress))
        assert job.latest_model() is not None
        assert blocks_of(job)
        pid = job._process.pid
        assert pid is not None
        if hasattr(os, "nice"):
            assert psutil.Process(pid).nice() > psutil.Process().nice()
    assert not psutil.pid_exists(pid)
    assert blocks_of(job) == []


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no signals")
@pytest.mark.parametrize("paused", [False, True])
def test_a_process_that_is_asked_to_end_clears_up_and_says_so(tmp_path: Path, paused: bool) -> None:
    """As a service manager asks the whole group of the window: what the steps hold is given back."""
    with job_of(fake_steps.endless, tmp_path) as job:
        events_until(job, is_a(Progress))
        if paused:
            job.pause()
            events_until(job, is_a(Paused))
        os.kill(job._process.pid or 0, signal.SIGTERM)
        events_until(job, is_a(Cancelled))
        assert job.state == "cancelled"
        assert (tmp_path / "run" / "closed").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no signals")
def test_what_a_terminal_sends_to_all_is_the_windows_matter(tmp_path: Path) -> None:
    with job_of(fake_steps.endless, tmp_path) as job:
        events_until(job, is_a(Progress))
        for name in ("SIGINT", "SIGHUP"):
            os.kill(job._process.pid or 0, getattr(signal, name))
            for _ in range(3):
                events_until(job, is_a(Progress))
            assert job.state == "running"


def test_a_job_that_never_started_can_be_closed(tmp_path: Path) -> None:
    job = TrainingJob(TrainRequest(clip_path=tmp_path, run_path=tmp_path, config=TrainConfig()))
    assert job.poll() == []
    assert job.latest_model() is None
    job.close()


OWNER = """
import os, sys, time
from pathlib import Path
from app.runs.job import TrainingJob
from app.runs.train_run import TrainRequest
from renderer.train.config import TrainConfig
from renderer.train.events import Progress
from tests.app import fake_steps

if __name__ == "__main__":
    out = Path(sys.argv[1])
    request = TrainRequest(clip_path=out, run_path=out, config=TrainConfig())
    job = TrainingJob(request, getattr(fake_steps, sys.argv[2]))
    job.start()
    while not any(isinstance(event, Progress) for event in job.poll()):
        time.sleep(0.01)
    assert job.latest_model() is not None
    print(job._process.pid, flush=True)
    if sys.argv[3] == "dies":
        job.pause()
        time.sleep(0.3)
        os.kill(os.getpid(), 9)
    job.close()
"""


def run_owner(tmp_path: Path, steps: str, ending: str) -> subprocess.CompletedProcess[str]:
    script = tmp_path / "owner.py"
    script.write_text(OWNER)
    root = Path(__file__).resolve().parents[3]
    command = [sys.executable, "-W", "error", str(script), str(tmp_path), steps, ending]
    environment = os.environ | {"PYTHONPATH": str(root)}
    return subprocess.run(command, capture_output=True, text=True, env=environment, timeout=2 * PATIENCE)


def test_nothing_is_left_for_the_resource_tracker_to_complain_of(tmp_path: Path) -> None:
    done = run_owner(tmp_path, "snapshot_then_endless", "closes")
    assert (done.returncode, done.stderr) == (0, "")


def test_the_worker_ends_when_its_window_is_killed_even_while_paused(tmp_path: Path) -> None:
    done = run_owner(tmp_path, "snapshot_then_endless", "dies")
    assert done.returncode == -9
    worker = int(done.stdout)
    deadline = time.monotonic() + PATIENCE
    while psutil.pid_exists(worker) and psutil.Process(worker).status() != psutil.STATUS_ZOMBIE:
        assert time.monotonic() < deadline, "the worker outlives its window"
        time.sleep(0.05)
    assert (tmp_path / "closed").exists()
