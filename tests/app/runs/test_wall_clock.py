"""The time in all beside the seconds of steps, wherever these are told."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Generator
from pathlib import Path

import pytest

from app.runs.run_folder import RunFolder
from app.runs.train_run import run_training
from app.runs.wall_clock import STEPS, WALL, WallClock, in_all
from renderer.train.events import Finished, Progress
from tests.app.conftest import Cli, request_of


def without_wall(run: RunFolder) -> None:
    """The log as versions wrote it that kept no wall seconds."""
    events = [{key: value for key, value in event.items() if key != "wall_seconds"} for event in run.events()]
    run.events_path.write_text("".join(f"{json.dumps(event)}\n" for event in events))


def test_the_clock_stands_while_an_event_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("app.runs.wall_clock.perf_counter", lambda: now[0])
    clock, closed = WallClock(5.0), []

    def work() -> Generator[float | None, None, None]:
        try:
            for _ in range(3):
                now[0] += 1.0
                yield clock.seconds()
        finally:
            closed.append(True)

    told = []
    for seconds in clock.over(work()):
        told.append(seconds)
        now[0] += 100.0
    assert told == [6.0, 7.0, 8.0]
    events = WallClock().over(work())
    next(events)
    events.close()
    assert closed == [True, True]
    assert WallClock(None).seconds() is None


def test_both_times_in_words() -> None:
    assert in_all(7.7, 1.4) == "7.7 s in total, 1.4 s training"
    assert in_all(None, 1.4) == "1.4 s training"
    assert in_all(None, None) == "not recorded"


def test_a_run_takes_longer_in_all_than_its_steps(
    clip_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Work before the first step counts, and a run that goes on adds to what it took before."""
    monkeypatch.setattr("app.runs.posing.camera_motion", lambda _: time.sleep(0.4))
    run = RunFolder(tmp_path / "run")
    for event in run_training(request_of(clip_path, run.path)):
        if isinstance(event, Progress):
            break
    before = run.wall_seconds()
    assert before is not None
    assert before > event.seconds + 0.4
    assert run.events()[-1]["wall_seconds"] == before == event.wall_seconds
    *_, finished = run_training(request_of(clip_path, run.path, resume=True))
    assert isinstance(finished, Finished)
    assert finished.wall_seconds is not None
    assert finished.wall_seconds > before + 0.4
    assert run.wall_seconds() == finished.wall_seconds == run.events()[-1]["wall_seconds"]
    (again,) = run_training(request_of(clip_path, run.path, resume=True))
    assert isinstance(again, Finished)
    assert again.wall_seconds == finished.wall_seconds


def test_every_json_has_both_times_and_says_what_they_are(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    run = tmp_path / "run"
    trained = json.loads(vesselsplat("train", clip_path, "--run", run, "--iterations", 2, "--json").out)
    assert trained["wall_seconds"] > trained["train_seconds"]
    evaluated = json.loads(vesselsplat("evaluate", run, "--json").out)
    known = json.loads(vesselsplat("info", run, "--json").out)["time"]
    for told, definitions in (
        (trained, trained["definitions"]),
        (evaluated["mean"], evaluated["definitions"]),
        (known, known["definitions"]),
    ):
        assert (told["train_seconds"], told["wall_seconds"]) == (
            trained["train_seconds"],
            trained["wall_seconds"],
        )
        assert (definitions["train_seconds"], definitions["wall_seconds"]) == (STEPS, WALL)
    both = in_all(trained["wall_seconds"], trained["train_seconds"])
    assert f"trained in {both}" in vesselsplat("evaluate", run).out
    assert both in vesselsplat("info", run).out
    assert both in vesselsplat("train", clip_path, "--run", run, "--iterations", 2, "--resume").out


def test_runs_of_earlier_versions_tell_the_seconds_of_their_steps(
    runs: dict[str, Path], clip_path: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    run = RunFolder(shutil.copytree(runs["original"], tmp_path / "run"))
    without_wall(run)
    assert json.loads(vesselsplat("evaluate", run.path, "--json").out)["mean"]["wall_seconds"] is None
    steps = in_all(None, RunFolder(run.path).train_seconds())
    assert f"trained in {steps}" in vesselsplat("evaluate", run.path).out
    assert steps in vesselsplat("info", run.path).out
    run.model_path.unlink()
    (run.path / "checkpoint-0000040.safetensors").unlink()
    lines = run.events_path.read_text().splitlines(keepends=True)
    run.events_path.write_text("".join(lines[:-1]))
    *_, finished = run_training(request_of(clip_path, run.path, resume=True))
    assert isinstance(finished, Finished)
    assert finished.wall_seconds is None
