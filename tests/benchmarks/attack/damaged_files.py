"""Damaged files over all readers: counts, and each failure with the number that makes it again."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import wait
from pathlib import Path
from threading import Lock
from typing import Any

from tests.benchmarks.attack import worker
from tests.benchmarks.attack.failure import Failure
from tests.benchmarks.attack.readers import readers
from tests.benchmarks.attack.worker import Case

WORKERS = 2
MOST_CASES = 250
"""Of one process."""
MOST_SECONDS = 1200
FORKS = get_context("forkserver")
"""Each worker is a copy of a process that has loaded all modules and done nothing."""
EXITS = Lock()
"""Starting a process asks all others how they ended, and that can be read once: of two threads that read it,
one finds 255."""


@dataclass(frozen=True)
class Done:
    """What a worker said, and how it ended: a negative code is a signal's number."""

    code: int
    out: str
    error: str


def read_damaged(seeds: Path, each: int, only: tuple[str, ...] = ()) -> tuple[int, list[Failure]]:
    """How many files were read, `each` of every reader, and what failed."""
    names = [name for name in readers(seeds) if (seeds / name).is_file() and (not only or name in only)]
    cases = [(name, number) for name in names for number in range(each)]
    size = min(MOST_CASES, -(-len(cases) // WORKERS))
    parts = [cases[start : start + size] for start in range(0, len(cases), size)]
    FORKS.set_forkserver_preload([worker.__name__])
    with ThreadPoolExecutor(WORKERS) as pool:
        found = list(pool.map(lambda part: list(_of_cases(seeds, part)), parts))
    return len(cases), [failure for failures in found for failure in failures]


def _of_cases(seeds: Path, cases: list[Case]) -> Iterator[Failure]:
    while cases:
        done = _worked(seeds, cases)
        lines = [_parsed(line) for line in done.out.splitlines()]
        for line in lines:
            if "error" in line:
                said = f"{line['error']}: {line['said']} ({line['in']}, from {line['from']})"
                yield Failure(line["reader"], line["number"], said)
        if done.code == 0:
            return
        words = [line for line in done.error.splitlines() if line.strip()]
        begun = max(sum("begins" in line for line in lines), 1)
        name, number = cases[begun - 1]
        yield Failure(name, number, f"ended with {done.code}: {words[-1][:200] if words else 'no word'}")
        cases = cases[begun:]


def _worked(seeds: Path, cases: list[Case]) -> Done:
    """A worker's process, which is killed where it never ends."""
    with tempfile.TemporaryDirectory() as scratch:
        streams = Path(scratch) / "out", Path(scratch) / "error"
        process = FORKS.Process(target=worker.work, args=(seeds, cases, streams))
        with EXITS:
            process.start()
        ended = wait([process.sentinel], MOST_SECONDS)
        with EXITS:
            if not ended:
                process.kill()
            process.join()
        assert process.exitcode is not None
        return Done(process.exitcode, *(path.read_text() if path.exists() else "" for path in streams))


def _parsed(line: str) -> dict[str, Any]:
    try:
        told = json.loads(line)
    except ValueError:
        return {}
    return told if isinstance(told, dict) else {}
