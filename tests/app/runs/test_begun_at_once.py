"""Two trainings that are begun on one folder before either has made it a run."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

import pytest

from app.errors import UserError
from app.runs.run_folder import RunFolder
from app.runs.run_lock import LOCK, NAME
from app.runs.train_run import run_training
from renderer.train.events import Finished, Planned, Progress, TrainEvent
from tests.app.conftest import CONFIG, request_of


def begun(clip: Path, run: Path) -> Generator[TrainEvent, None, None]:
    """Found the folder vacant; other settings than the first has."""
    events = run_training(request_of(clip, run, config=replace(CONFIG, iterations=20)))
    assert isinstance(next(events), Planned)
    return events


def files_of(run: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in run.iterdir()}


def test_the_second_is_refused_while_the_first_trains(clip_path: Path, tmp_path: Path) -> None:
    second = begun(clip_path, tmp_path / "run")
    first = run_training(request_of(clip_path, tmp_path / "run"))
    next(event for event in first if isinstance(event, Progress))
    with pytest.raises(UserError, match="trained by another process"):
        list(second)
    assert isinstance(list(first)[-1], Finished)
    record = RunFolder(tmp_path / "run").record()
    assert record.config == CONFIG
    assert [e["iteration"] for e in RunFolder(tmp_path / "run").events("Started", "Finished")] == [0, 40]


def test_the_second_harms_nothing_of_a_first_that_is_over(clip_path: Path, tmp_path: Path) -> None:
    second = begun(clip_path, tmp_path / "run")
    list(run_training(request_of(clip_path, tmp_path / "run")))
    before = files_of(tmp_path / "run")
    with pytest.raises(UserError, match="expected an empty or new folder for the run"):
        list(second)
    assert files_of(tmp_path / "run") == before


def test_what_is_left_of_a_run_that_was_killed_as_it_began_is_no_hindrance(
    clip_path: Path, tmp_path: Path
) -> None:
    for name in (NAME, LOCK):
        (tmp_path / name).touch()
    assert isinstance(list(run_training(request_of(clip_path, tmp_path)))[-1], Finished)
