"""The log of errors: what goes there, that it stays small, and that it is never in the way."""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from app.console import log_file
from app.console.log_file import KEPT, NAME, SIZE, logged
from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.work.background import Channel
from app.gui.work.settings import Places


def broken(request: object) -> None:
    raise KeyError("a bug of the work")


def text(folder: Path) -> str:
    return (folder / NAME).read_text(encoding="utf-8")


def test_the_first_line_is_the_version_and_nothing_is_left_behind(tmp_path: Path) -> None:
    hook, level, handlers = threading.excepthook, log_file.LOG.level, list(log_file.LOG.handlers)
    with logged(tmp_path / "log", "VesselSplat 1.2.3 on a system"):
        pass
    assert text(tmp_path / "log").splitlines()[0].endswith("VesselSplat 1.2.3 on a system")
    assert (threading.excepthook, log_file.LOG.level, log_file.LOG.handlers) == (hook, level, handlers)


def test_failed_work_is_there_with_its_place_in_the_code(tmp_path: Path) -> None:
    channel: Channel[str, str] = Channel(broken)  # type: ignore[arg-type]
    with logged(tmp_path, "start"):
        channel.ask("a request")
        channel.run_waiting()
    assert "a bug of the work" in text(tmp_path)
    assert "in broken" in text(tmp_path)


def test_what_a_person_was_shown_is_there(tmp_path: Path) -> None:
    with logged(tmp_path, "start"):
        actions.fail(
            AppState(Places(tmp_path, tmp_path, tmp_path)), "expected a clip, got a folder of text files"
        )
    assert "expected a clip" in text(tmp_path)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_an_error_of_a_thread_is_there_and_still_told_as_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[object] = []
    monkeypatch.setattr(threading, "excepthook", told.append)
    with logged(tmp_path, "start"):
        thread = threading.Thread(target=lambda: broken(None))
        thread.start()
        thread.join()
    assert "uncaught in a thread" in text(tmp_path)
    assert "in broken" in text(tmp_path)
    assert len(told) == 1


def test_an_error_that_ends_the_window_is_there_and_goes_on(tmp_path: Path) -> None:
    with pytest.raises(KeyError, match="a bug"), logged(tmp_path, "start"):
        broken(None)
    assert "ended by an error" in text(tmp_path)
    assert "in broken" in text(tmp_path)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no such device on this system")
def test_a_full_disk_is_no_news_for_the_terminal(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / NAME).symlink_to("/dev/full")
    with logged(tmp_path, "start"):
        log_file.LOG.error("more")
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("end", [KeyboardInterrupt, SystemExit])
def test_an_end_that_was_asked_for_is_no_error(tmp_path: Path, end: Callable[[], BaseException]) -> None:
    with pytest.raises(BaseException), logged(tmp_path, "start"):  # noqa: B017, PT011
        raise end()
    assert "error" not in text(tmp_path)


def test_it_stays_small(tmp_path: Path) -> None:
    line = "x" * 1000
    with logged(tmp_path, "start"):
        for _ in range((KEPT + 2) * SIZE // 1000):
            log_file.LOG.error(line)
    files = list(tmp_path.glob(f"{NAME}*"))
    assert len(files) == KEPT + 1
    assert all(file.stat().st_size <= SIZE for file in files)


def test_it_goes_on_where_another_window_holds_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def held(*names: object) -> None:
        raise PermissionError(13, "used by another process")

    monkeypatch.setattr(log_file, "SIZE", 2000)
    monkeypatch.setattr(os, "rename", held)
    with logged(tmp_path, "start"):
        for number in range(60):
            log_file.LOG.error("error number %d", number)
    assert all(f"error number {number}\n" in text(tmp_path) for number in range(60))
    assert capfd.readouterr().err == ""


def test_where_nothing_can_be_written_the_program_runs_without(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    ran = False
    with logged(tmp_path / "file", "start"):
        logging.getLogger("app.some").info("lost")
        ran = True
    assert ran
