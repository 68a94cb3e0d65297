"""Signals that end a command: one line, an exit code that names the signal, nothing half-written."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
from pydantic import model_serializer
from pydantic.dataclasses import dataclass
from pydantic_core import to_jsonable_python

from app.console.ending import EndingSignals, noted, unheard

ROOT = Path(__file__).resolve().parents[3]


def pictures(folder: Path, count: int = 400) -> Path:
    """Enough of them that enhancing takes longer than a signal needs."""
    folder.mkdir()
    noise = np.random.default_rng(0).integers(0, 255, (480, 640, 3), np.uint8)
    cv2.imwrite(str(folder / "0.jpg"), noise)
    for number in range(1, count):
        (folder / f"{number}.jpg").hardlink_to(folder / "0.jpg")
    return folder


def ended_by(number: int, given: Path, out: Path) -> tuple[int, str]:
    """Exit code and stderr of an enhancement that is under way when the signal comes."""
    process = subprocess.Popen(
        [sys.executable, "-m", "app", "enhance", str(given), str(out)],
        stderr=subprocess.PIPE,
        cwd=ROOT,
        text=True,
    )
    until = time.monotonic() + 60
    while not list(given.parent.glob(".out-*/2.png")) and time.monotonic() < until:
        time.sleep(0.01)
    process.send_signal(number)
    error = process.communicate(timeout=60)[1]
    return process.returncode, error


def idle() -> None:
    """In a process of its own."""


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="Windows has no such signals")
def test_a_process_is_not_ended_by_ctrl_c_while_python_starts_in_it() -> None:
    process = multiprocessing.get_context("spawn").Process(target=idle)
    with unheard():
        process.start()
    assert process.pid is not None
    os.kill(process.pid, signal.SIGINT)
    process.join(60)
    assert process.exitcode == 0


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="Windows has no such signals")
@pytest.mark.parametrize(("name", "code"), [("SIGTERM", 143), ("SIGHUP", 129), ("SIGINT", 130)])
def test_a_command_ends_in_one_line_and_leaves_nothing(tmp_path: Path, name: str, code: int) -> None:
    given, out = pictures(tmp_path / "given"), tmp_path / "out"
    returned, error = ended_by(getattr(signal, name), given, out)
    assert (returned, error.splitlines()[-1]) == (code, "vesselsplat: interrupted")
    assert "Traceback" not in error
    assert sorted(path.name for path in tmp_path.iterdir()) == ["given"]


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="Windows has no such signals")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_signal_that_is_noted_interrupts_at_the_end_alone(number: signal.Signals, code: int) -> None:
    """A window ends its frame first: Dear ImGui would be left half-way."""
    done = []

    def draw() -> None:
        with noted() as has_come:
            assert not has_come()
            os.kill(os.getpid(), number)
            for _ in range(3):
                time.sleep(0.01)
            assert has_come()
            done.append("frame")

    signals = EndingSignals()
    with signals, pytest.raises(KeyboardInterrupt):
        draw()
    assert done == ["frame"]
    assert signals.code == code


def test_an_interrupt_that_python_cannot_raise_comes_again() -> None:
    """As in what numba's compiler calls back, where Python prints it and goes on."""

    class Held:
        def __del__(self) -> None:
            raise KeyboardInterrupt

    def wait() -> None:
        until = time.monotonic() + 10
        while time.monotonic() < until:
            time.sleep(0.01)

    hook = sys.unraisablehook
    with EndingSignals():
        Held()
        with pytest.raises(KeyboardInterrupt):
            wait()
    assert sys.unraisablehook is hook


def test_an_interrupt_that_a_library_wraps_in_an_error_of_its_own_stays_one() -> None:
    """As pydantic does with what a serializer in Python raises."""

    @dataclass
    class Interrupting:
        @model_serializer
        def written(self) -> str:
            signal.raise_signal(signal.SIGINT)
            return "written"

    with pytest.raises(KeyboardInterrupt), EndingSignals():
        to_jsonable_python(Interrupting())


def test_an_error_without_a_signal_stays_the_error() -> None:
    with pytest.raises(ZeroDivisionError), EndingSignals():
        _ = 1 / 0


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="Windows has no such signals")
def test_a_signal_that_was_ignored_stays_so() -> None:
    """As nohup leaves it."""
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with EndingSignals():
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
            assert signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    finally:
        signal.signal(signal.SIGHUP, before)
