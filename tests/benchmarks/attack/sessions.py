"""Damaged sessions taken up in a window: counts, and each failure with the number that makes it again."""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.benchmarks.attack.failure import Failure
from tests.benchmarks.attack.screen import screen

WHAT = "session"
SILENT = 60.0
"""Seconds without a line after which the window is said to hang: it says itself what takes over 10 s."""


def attack_sessions(seeds: Path, count: int) -> tuple[int, list[Failure]]:
    """So many sessions, in as few windows as there are ends of the process; under Xvfb without a screen."""
    taken: list[bool] = []
    failures = list(_found(seeds, count, taken))
    print(f"{sum(taken)} of {count} damaged sessions were taken up, the others refused")
    return count, failures


def _found(seeds: Path, count: int, taken: list[bool]) -> Iterator[Failure]:
    first = 0
    while first < count:
        begun, done = first - 1, False
        command = (sys.executable, "-m", "tests.benchmarks.attack.session_window")
        process = subprocess.Popen(
            [*screen(), *command, str(seeds), str(first), str(count)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        errors: list[str] = []
        for line in _lines(process, errors):
            begun = line.get("begins", begun)
            taken += [line["taken"]] if "taken" in line else []
            done = done or "done" in line
            if "error" in line:
                yield Failure(WHAT, line["number"], line["error"])
        if done and process.returncode == 0:
            return
        if process.returncode != 1:
            yield Failure(WHAT, begun, _end(process.returncode, errors))
        first = max(begun, first) + 1


def _lines(process: subprocess.Popen[str], errors: list[str]) -> Iterator[dict[str, Any]]:
    """What it says until it ends, or is silent for too long and is ended."""
    said: queue.Queue[str | None] = queue.Queue()
    readers = [
        threading.Thread(target=_read, args=(process.stdout, said.put)),
        threading.Thread(target=_read, args=(process.stderr, lambda line: errors.append(line or ""))),
    ]
    for reader in readers:
        reader.start()
    try:
        while (line := said.get(timeout=SILENT)) is not None:
            if line.startswith("{"):
                yield json.loads(line)
    except queue.Empty:
        errors.append(f"the window hangs: silent for {SILENT:.0f} s")
        os.killpg(process.pid, 9)
    process.wait()
    for reader in readers:
        reader.join()


def _read(stream: Any, take: Any) -> None:
    for line in stream:
        take(line)
    take(None)


def _end(code: int, errors: list[str]) -> str:
    """The last words, and where a signal met Python."""
    words = [line.strip() for line in errors if line.strip()]
    fatal = [line for line in words if line.startswith(("Fatal", "the window hangs"))]
    places = [line for line in words if line.startswith("File ")]
    told = fatal[-1:] + places[:1] or words[-1:]
    return f"ended with {code}: {'; '.join(told)[:300]}"
