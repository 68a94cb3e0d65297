"""Runs that were cut short, or come from elsewhere, and go on."""

from __future__ import annotations

import re
import shutil
from contextlib import suppress
from pathlib import Path

import pytest

from app.errors import UserError
from app.runs.run_folder import RunFolder
from app.runs.run_lock import NAME
from app.runs.train_run import run_training
from renderer.leftovers import temporary_name
from renderer.train.events import Finished
from tests.app.conftest import CONFIG, request_of


def test_a_log_that_was_cut_off_behind_the_model_is_completed(
    tmp_path: Path, runs: dict[str, Path], clip_path: Path
) -> None:
    """Killed after the model was written, before that was logged."""
    whole = RunFolder(runs["original"])
    run = RunFolder(shutil.copytree(whole.path, tmp_path / "run"))
    lines = run.events_path.read_text().splitlines(keepends=True)
    run.events_path.write_text("".join(line for line in lines if '"Finished"' not in line))
    for _ in range(2):
        (finished,) = run_training(request_of(clip_path, run.path, resume=True))
        assert isinstance(finished, Finished)
        assert finished.iteration == CONFIG.iterations
        assert finished.seconds == pytest.approx(whole.train_seconds(), rel=0.2)
    assert [event["event"] for event in run.events()].count("Finished") == 1


@pytest.mark.parametrize(
    "linked", ["events.jsonl", temporary_name("checkpoint-0000040.safetensors")], ids=["log", "checkpoint"]
)
def test_nothing_is_written_through_links_in_a_run(
    tmp_path: Path, runs: dict[str, Path], clip_path: Path, linked: str
) -> None:
    """Of an unfinished run that came from elsewhere."""
    run = RunFolder(shutil.copytree(runs["original"], tmp_path / "run"))
    run.model_path.unlink()
    (run.path / "checkpoint-0000040.safetensors").unlink()
    outside = tmp_path / "outside"
    outside.write_bytes(b"precious")
    (run.path / linked).unlink(missing_ok=True)
    (run.path / linked).symlink_to(outside)
    with suppress(UserError):
        list(run_training(request_of(clip_path, run.path, resume=True)))
    assert outside.read_bytes() == b"precious"


@pytest.mark.parametrize("linked", ["model.safetensors", NAME])
def test_links_in_a_run_make_no_files_elsewhere(
    tmp_path: Path, runs: dict[str, Path], clip_path: Path, linked: str
) -> None:
    run = RunFolder(shutil.copytree(runs["original"], tmp_path / "run"))
    run.model_path.unlink()
    (run.path / "checkpoint-0000040.safetensors").unlink()
    (run.path / linked).symlink_to(tmp_path / "outside")
    events = list(run_training(request_of(clip_path, run.path, resume=True)))
    assert isinstance(events[-1], Finished)
    assert not (tmp_path / "outside").exists()
    assert run.is_finished
    assert not run.model_path.is_symlink()


def test_a_run_that_is_not_there_is_told_from_a_folder_that_is_none(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"got no such path: .*gone$"):
        RunFolder(tmp_path / "gone").record()
    with pytest.raises(UserError, match=f"found none in {re.escape(str(tmp_path))}$"):
        RunFolder(tmp_path).record()
