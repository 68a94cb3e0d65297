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

WORKERS = 2
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
    FORKS.set_forkserver_preload([worker.__name__])
    with ThreadPoolExecutor(WORKERS) as pool:
        found = list(pool.map(lambda name: list(_of_reader(seeds, name, each)), names))
    return each * len(names), [failure for failures in found for failure in failures]


def _of_reader(seeds: Path, name: str, each: int) -> Iterator[Failure]:
    first = 0
    while first < each:
        done = _worked(seeds, name, first, each)
        lines = [_parsed(line) for line in done.out.splitlines()]
        begun = [line["begins"] for line in lines if "begins" in line]
        for line in lines:
            if "error" in line:
                said = f"{line['error']}: {line['said']} ({line['in']}, from {line['from']})"
                yield Failure(name, line["number"], said)
        words = [line for line in done.error.splitlines() if line.strip()]
        if done.code == 0:
            return
        last = begun[-1] if begun else first
        yield Failure(name, last, f"ended with {done.code}: {words[-1][:200] if words else 'no word'}")
        first = last + 1


def _worked(seeds: Path, name: str, first: int, last: int) -> Done:
    """A worker's process, which is killed where it never ends."""
    with tempfile.TemporaryDirectory() as scratch:
        streams = Path(scratch) / "out", Path(scratch) / "error"
        process = FORKS.Process(target=worker.work, args=(seeds, name, range(first, last), streams))
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
