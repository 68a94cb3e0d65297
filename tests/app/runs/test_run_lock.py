from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import psutil
import pytest

from app.errors import UserError
from app.runs.run_folder import RunFolder
from app.runs.run_lock import NAME, holder, locked, require_free
from renderer.leftovers import machine
from tests.app.fake_steps import model_of

HOLDS = """
import sys, time
from pathlib import Path
from app.runs.run_lock import locked
with locked(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


def test_a_run_is_held_only_while_it_is_trained(tmp_path: Path) -> None:
    assert holder(tmp_path) is None
    with locked(tmp_path):
        require_free(tmp_path)  # From this process itself.
        assert holder(tmp_path) == psutil.Process().pid
        with pytest.raises(UserError, match="another process"), locked(tmp_path):
            pass
        assert holder(tmp_path) == psutil.Process().pid
    assert list(tmp_path.iterdir()) == []


def test_a_killed_process_holds_nothing(tmp_path: Path) -> None:
    root = str(Path(__file__).parents[3])
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDS, str(tmp_path)],
        stdout=subprocess.PIPE,
        env={"PYTHONPATH": root},
    )
    assert process.stdout is not None
    assert process.stdout.readline() == b"held\n"
    with pytest.raises(UserError, match=f"trained by another process, {process.pid}: "):
        require_free(tmp_path)
    assert holder(tmp_path) == process.pid
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    assert (tmp_path / NAME).exists()
    assert holder(tmp_path) is None


def test_a_number_that_is_used_again_is_another_process(tmp_path: Path) -> None:
    number = os.getpid()
    (tmp_path / NAME).write_text(json.dumps({"process": number, "mark": f"{number}.1"}))
    assert holder(tmp_path) is None


def test_a_reader_of_its_file_does_not_end_a_training(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on Windows, where nobody removes what somebody has open."""
    real = Path.unlink

    def busy(path: Path, missing_ok: bool = False) -> None:
        if path.name == NAME:
            raise PermissionError(13, "in use", str(path))
        real(path, missing_ok)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "unlink", busy)
        with locked(tmp_path):
            pass
    with locked(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


def test_who_holds_it_by_a_file_of_former_versions(tmp_path: Path) -> None:
    process = psutil.Process()
    for shift, found in ((0, process.pid), (3600, None)):
        facts = {"process": process.pid, "began": process.create_time() - shift}
        (tmp_path / NAME).write_text(json.dumps(facts))
        assert holder(tmp_path) == found


def test_it_is_held_whatever_becomes_of_the_clock(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """psutil has moments of processes in the clock's time."""
    real = psutil.Process.create_time
    with locked(tmp_path):
        monkeypatch.setattr(psutil.Process, "create_time", lambda self: real(self) + 3600)
        assert holder(tmp_path) == os.getpid()


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"process": "x", "began": 0}', '{"process": 1e99}'])
def test_a_damaged_file_holds_nothing(tmp_path: Path, text: str) -> None:
    (tmp_path / NAME).write_text(text)
    assert holder(tmp_path) is None


def test_a_model_that_was_half_written_goes_whichever_machine_wrote_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = list[str]()

    def write(path: Path, *given: Any) -> None:
        names.extend(each.name for each in tmp_path.iterdir())
        path.write_bytes(b"half")
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("renderer.gaussians.write_arrays", write)
    with pytest.raises(OSError, match="No space left"):
        RunFolder(tmp_path).save_model(model_of(3))
    (name,) = names
    (tmp_path / name.replace(machine(), "0badcafe")).write_bytes(b"half")
    with locked(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


RACES = """
import sys, time
from pathlib import Path
from app.errors import UserError
from app.runs.run_lock import locked
print("ready", flush=True)
start = float(sys.stdin.readline())
while time.time() < start:
    pass
try:
    with locked(Path(sys.argv[1])):
        print("held", flush=True)
        sys.stdin.readline()
except UserError as error:
    print("refused:", error, flush=True)
"""


@pytest.mark.parametrize("attempt", range(4))
def test_of_two_that_begin_at_once_one_is_refused(tmp_path: Path, attempt: int) -> None:
    """A stale file of a killed process lies there in every other attempt."""
    if attempt % 2:
        (tmp_path / NAME).write_text(json.dumps({"process": 999_999_999, "began": 0.0}))
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", RACES, str(tmp_path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={"PYTHONPATH": str(Path(__file__).parents[3])},
            text=True,
        )
        for _ in range(2)
    ]
    for process in processes:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
    start = f"{time.time() + 0.05}\n"
    for process in processes:
        assert process.stdin is not None
        process.stdin.write(start)
        process.stdin.flush()
    said = [process.stdout.readline() for process in processes if process.stdout is not None]
    assert sorted(line.split(":")[0].strip() for line in said) == ["held", "refused"]
    for process in processes:
        process.communicate("\n")
    assert list(tmp_path.iterdir()) == []
