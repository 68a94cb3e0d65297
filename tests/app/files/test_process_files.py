"""Files of windows: whose process lives is told by more than its number."""

from __future__ import annotations

import os
import time
from pathlib import Path
from zlib import crc32

import psutil
import pytest

from app.files import process_files
from app.files.process_files import FORGOTTEN, claimed, left_behind, own_file
from app.gui.session_file import (
    Session,
    SessionSource,
    autosave_path,
    mended_session,
    recoverable,
    write_session,
)
from app.runs.queue_file import keep_queue, queue_file, take_over
from app.runs.train_run import TrainRequest
from renderer import leftovers
from renderer.leftovers import mark_of
from renderer.train.config import TrainConfig

LONG = 1e6


def kept(folder: Path, age: float = 0.0, name: str = "") -> Path:
    """The file of this process, or one of that name, written so many seconds before."""
    path = folder / name if name else own_file(folder, "kept", ".json")
    path.write_text("precious")
    os.utime(path, (time.time() - age,) * 2)
    return path


def is_left(folder: Path) -> bool:
    return bool(left_behind(folder, "kept", ".json"))


def test_ones_own_file_is_not_left_however_old(tmp_path: Path) -> None:
    kept(tmp_path, LONG)
    assert not is_left(tmp_path)


def test_a_dead_process_of_the_same_number_has_left_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = kept(tmp_path)
    monkeypatch.setattr(process_files, "TOKEN", "01234567")
    assert left_behind(tmp_path, "kept", ".json") == [before]
    assert own_file(tmp_path, "kept", ".json") != before


def of_process(mark: str) -> str:
    """The name of its file."""
    return own_file(Path(), "kept", ".json").name.replace(f"-{mark_of(os.getpid())}-", f"-{mark}-")


@pytest.mark.parametrize("age", [-LONG, 0.0, LONG])
def test_another_living_process_keeps_its_file_whatever_the_clock_says(tmp_path: Path, age: float) -> None:
    kept(tmp_path, age, of_process(mark_of(os.getppid())))
    assert not is_left(tmp_path)


def test_a_later_process_of_its_number_does_not_keep_it(tmp_path: Path) -> None:
    kept(tmp_path, 0, of_process(f"{os.getppid()}.1"))
    assert is_left(tmp_path)


def test_of_files_of_former_versions_the_clock_tells(tmp_path: Path) -> None:
    other = os.getppid()
    kept(tmp_path, 0, of_process(str(other)))
    assert not is_left(tmp_path)
    kept(tmp_path, time.time() - psutil.Process(other).create_time() + 10, of_process(str(other)))
    assert is_left(tmp_path)


def test_another_machines_file_stays_till_it_is_forgotten(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for mark in (mark_of(os.getpid()), "999999999.1"):
        path = kept(tmp_path, 0, of_process(mark))
        with monkeypatch.context() as patch:
            patch.setattr(process_files, "machine", lambda: "0badcafe")
            patch.setattr(process_files, "machines", lambda: {"0badcafe"})
            assert not is_left(tmp_path)
            os.utime(path, (time.time() - FORGOTTEN - 60,) * 2)
            assert is_left(tmp_path)
        path.unlink()


def test_names_of_former_versions_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    left = kept(tmp_path, 0, "kept-999999999.json")
    assert left_behind(tmp_path, "kept", ".json") == [left]
    left.unlink()
    # By the installation, on systems that name it.
    (tmp_path / "id").write_text("0123")
    monkeypatch.setattr(leftovers, "INSTALLATION", tmp_path / "id")
    leftovers.machines.cache_clear()
    left = kept(tmp_path, 0, f"kept-999999999-{crc32(b'0123'):08x}-01234567.json")
    kept(tmp_path, 0, f"kept-{os.getppid()}.json")
    kept(tmp_path, 0, "kept-of-somebody.json")
    assert left_behind(tmp_path, "kept", ".json") == [left]
    leftovers.machines.cache_clear()


def test_of_two_that_claim_at_once_each_file_goes_to_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = [kept(tmp_path, age, f"kept-99999999{age}.json") for age in (9, 8)]
    seen = left_behind(tmp_path, "kept", ".json")
    assert seen == left
    first = claimed(tmp_path, "kept", ".json")
    assert [path.read_text() for path in first] == ["precious", "precious"]
    monkeypatch.setattr(process_files, "left_behind", lambda *_: seen)
    assert claimed(tmp_path, "kept", ".json") == []
    assert sorted(tmp_path.iterdir()) == sorted(first)


def test_what_was_claimed_and_not_done_is_left_again(tmp_path: Path) -> None:
    kept(tmp_path, 0, "kept-999999999.json")
    assert claimed(tmp_path, "kept", ".json") == left_behind(tmp_path, "kept", ".json") != []


def test_queue_and_session_of_a_window_with_the_same_number_outlive_the_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    request = TrainRequest(clip_path=tmp_path, run_path=tmp_path, config=TrainConfig())
    keep_queue(queue_file(tmp_path), [request])
    write_session(autosave_path(tmp_path), Session(source=SessionSource("x"), notes="precious"))
    monkeypatch.setattr(process_files, "TOKEN", "01234567")
    assert take_over(tmp_path) == ((request,), "")
    assert list(tmp_path.glob("queue-*")) == [queue_file(tmp_path)]
    left = recoverable(tmp_path)
    assert left is not None
    write_session(autosave_path(tmp_path), Session(source=SessionSource("y")))
    assert mended_session(left)[0].notes == "precious"
