"""The real window killed or ended at its work: files are whole, nothing runs on, the next start clears up."""

from __future__ import annotations

import json
import os
import random
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Final

import psutil

from tests.benchmarks.attack.failure import Failure
from tests.benchmarks.attack.kills import CODES
from tests.benchmarks.attack.screen import display
from tests.benchmarks.attack.window_files import (
    broken,
    cannot_go_on,
    half_enhanced,
    shared_by,
    shared_memory,
    staged,
    unlike_its_record,
)
from tests.benchmarks.attack.window_work import BEGINS
from tests.benchmarks.attack.writers import environment

WORKS: Final = {"video": 4.0, "save": 2.0, "picture": 2.0, "enhance": 3.0, "train": 8.0}
"""What the window is at, and seconds within which something else is going on there."""
ENDINGS: Final = {"SIGKILL": -9, **CODES}
TURN: Final = ("SIGKILL", "SIGTERM", "SIGKILL", "SIGINT", "SIGKILL", "SIGHUP", "SIGKILL")
"""Of 70, 40 are killed, and 10 are ended by each of the others."""
TO_OPEN, TO_END = 60.0, 10.0
"""Seconds after which a window hangs."""
MARK: Final = "VESSELSPLAT_CONFIG_DIR"
"""Tells the processes of one case by its own folder."""


@dataclass(frozen=True)
class Case:
    """One window with folders of its own."""

    number: int
    seeds: Path
    folder: Path
    display: str
    model: list[str]
    """Of all cases: the fingerprint of what training comes to, once it is known."""
    left: list[int]
    """Numbers of cases that left something for the next start to clear away."""

    @property
    def work(self) -> str:
        return [*WORKS][self.number % len(WORKS)]

    @property
    def ending(self) -> str:
        return TURN[self.number % len(TURN)]

    @property
    def takes_all(self) -> bool:
        """The whole group, as a terminal does, or the window alone."""
        return self.number // len(TURN) % 2 == 0

    @property
    def moment(self) -> float:
        """Seconds after the work has begun."""
        return random.Random(self.number).uniform(0.0, WORKS[self.work])

    @property
    def is_aimed(self) -> bool:
        """At the moment when a file, or a set of files, gets its name."""
        return self.number % 2 == 1

    @property
    def pictures(self) -> Path:
        return self.folder / "pictures"

    def environment(self) -> dict[str, str]:
        own = {"HOME": "home", "TMPDIR": "tmp", MARK: "config", "VESSELSPLAT_RUNS_DIR": "runs",
               "VESSELSPLAT_PICTURES_DIR": "pictures"}  # fmt: skip
        places = {name: str(self.folder / folder) for name, folder in own.items()}
        cache = {"XDG_CACHE_HOME": str(self.folder.parent / "cache"), "LIBGL_ALWAYS_SOFTWARE": "1"}
        return environment() | places | cache | {"DISPLAY": self.display}

    def processes(self) -> set[int]:
        """That live now."""
        return {process.pid for process in psutil.process_iter() if _is_of(process, self.folder / "config")}


def _is_of(process: psutil.Process, config: Path) -> bool:
    try:
        return process.environ().get(MARK) == str(config) and process.status() != psutil.STATUS_ZOMBIE
    except (psutil.Error, OSError):
        return False


def attack_window(seeds: Path, count: int) -> tuple[int, list[Failure]]:
    """`count` windows are ended at their work; then each is started once more and closed."""
    failures: list[Failure] = []
    model: list[str] = []
    left: list[int] = []
    with tempfile.TemporaryDirectory() as scratch, display() as name:
        for number in range(count):
            case = Case(number, seeds, Path(scratch) / str(number), name, model, left)
            what = f"{case.ending}: window, {case.work}"
            failures += [Failure(what, number, error) for error in _of_one(case)]
            shutil.rmtree(case.folder, ignore_errors=True)
    print(f"{len(left)} of {count} windows left something for the next start to clear away")
    return count, failures


def _of_one(case: Case) -> Iterator[str]:
    for name in ("home", "tmp", "config", "runs", "pictures"):
        (case.folder / name).mkdir(parents=True)
    (case.folder / "config" / "settings.json").write_text(json.dumps({"acknowledged": True}))
    before, processes = shared_memory(), set[int]()
    yield from _ended(case, processes)
    if case.ending != "SIGKILL" and (left := staged(case.folder)):
        yield f"left at once: {left[:4]}"
    if staged(case.folder) or shared_by(processes, before):
        case.left.append(case.number)
    if not any(name.endswith(".commit") or ".commit/" in name for name in staged(case.folder)):
        yield from (f"before the next start, {wrong}" for wrong in broken(case.folder))
    yield from _started_again(case, processes)
    yield from _runs_on(case)
    if left := staged(case.folder):
        yield f"left after the next start: {left[:4]}"
    if left := [path.name for path in (case.folder / "tmp").iterdir()]:
        yield f"left among temporary files: {left[:4]}"
    if left := shared_by(processes, before):
        yield f"left in shared memory: {left[:4]}"
    if left := [path.name for path in (case.folder / "config").glob("autosave-*")]:
        yield f"left of a session that was taken up: {left}"
    if not (case.folder / "config" / "settings.json").exists():
        yield "the settings are gone"
    yield from broken(case.folder)
    yield from unlike_its_record(case.pictures, case.seeds, case.folder)
    yield from half_enhanced(case.pictures, {"images": len(list((case.seeds / "endonerf/images").glob("*")))})
    yield from cannot_go_on(case.folder / "runs", case.model)


def _ended(case: Case, processes: set[int]) -> Iterator[str]:
    """What went wrong from its start to its end, and its processes."""
    with _window(case, case.work, str(case.seeds / "vesselsplat")) as window:
        assert window.stdout is not None
        said = _first_line(window.stdout, window)
        if said != BEGINS:
            _end_all(window)
            yield f"does not begin: {said} {_words(window)}"
            return
        time.sleep(case.moment)
        processes |= case.processes()
        if case.is_aimed:
            _wait_for_a_file(case)
        _end(case, window)
        try:
            window.wait(TO_END)
        except subprocess.TimeoutExpired:
            _end_all(window)
            yield f"hangs for more than {TO_END:.0f} s"
            return
        yield from _runs_on(case)
        told, errors = window.communicate()
        yield from _at_the_end(case, window.returncode, errors)
        # Training that starts up is ended by a signal to all: that is told in the last frame.
        yield from (line for line in told.splitlines() if line and case.ending not in line)


def _at_the_end(case: Case, code: int, errors: str) -> Iterator[str]:
    if "Traceback" in errors:
        yield f"a traceback: {errors[-400:]}"
    if code != ENDINGS[case.ending]:
        yield f"ended with {code}: {errors[-200:]}"
    elif case.ending != "SIGKILL" and errors.strip() != "vesselsplat: interrupted":
        yield f"said: {errors[-200:]}"


def _window(case: Case, work: str, *paths: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "tests.benchmarks.attack.window_work", work, *paths],
        cwd=case.folder, env=case.environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, errors="replace", start_new_session=True,
    )  # fmt: skip


def _first_line(stream: IO[str], window: subprocess.Popen[str]) -> str:
    """Empty when it ends, or does not come to its work in time."""
    ready, _, _ = select.select([stream], [], [], TO_OPEN)
    return stream.readline().strip() if ready else ""


def _wait_for_a_file(case: Case) -> None:
    """Not for long: some work ends without one."""
    places = [case.folder / name for name in ("pictures", "config", "runs")]
    end, before = time.monotonic() + WORKS[case.work], _names(places)
    while _names(places) == before and time.monotonic() < end:
        pass
    time.sleep(random.Random(case.number).choice((0.0, 0.0005, 0.002)))


def _names(places: list[Path]) -> set[str]:
    """Of the files that a person sees, and of sets that are about to get theirs."""
    listed = {
        os.path.join(folder, name)
        for place in places
        for folder, below, files in os.walk(place)
        for name in (*below, *files)
    }
    return {name for name in listed if ".partial" not in name}


def _end(case: Case, window: subprocess.Popen[str]) -> None:
    number = getattr(signal, case.ending)
    try:
        if case.takes_all:
            os.killpg(window.pid, number)
        else:
            window.send_signal(number)
    except ProcessLookupError:
        pass  # It has ended by itself, which its code tells.


def _end_all(window: subprocess.Popen[str]) -> None:
    with suppress(ProcessLookupError):
        os.killpg(window.pid, signal.SIGKILL)


def _words(window: subprocess.Popen[str]) -> str:
    told, errors = window.communicate()
    return f"({window.returncode}) {told[-200:]} {errors[-300:]}"


def _runs_on(case: Case) -> Iterator[str]:
    """What is left of training sees within a step that its window is gone."""
    end = time.monotonic() + TO_END
    while left := case.processes():
        if time.monotonic() > end:
            told = [" ".join(psutil.Process(number).cmdline())[-100:] for number in left]
            yield f"still runs after {TO_END:.0f} s: {told}"
            for number in left:
                psutil.Process(number).kill()
            return
        time.sleep(0.05)


def _started_again(case: Case, processes: set[int]) -> Iterator[str]:
    """And closed: exit code 0, and not a word but of what is wrong."""
    with _window(case, "close") as window:
        try:
            told, errors = window.communicate(timeout=TO_OPEN)
        except subprocess.TimeoutExpired:
            _end_all(window)
            yield f"the next start hangs: {_words(window)}"
            return
        processes.add(window.pid)
        if window.returncode or errors.strip() or told.strip():
            yield f"the next start ended with {window.returncode}: {told[-200:]} {errors[-400:]}"
