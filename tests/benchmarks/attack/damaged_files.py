"""Damaged files over all readers: counts, and each failure with the number that makes it again."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from tests.benchmarks.attack.failure import Failure
from tests.benchmarks.attack.readers import readers

WORKERS = 2
MOST_SECONDS = 1200


def read_damaged(seeds: Path, each: int, only: tuple[str, ...] = ()) -> tuple[int, list[Failure]]:
    """How many files were read, `each` of every reader, and what failed."""
    names = [name for name in readers(seeds) if (seeds / name).is_file() and (not only or name in only)]
    with ThreadPoolExecutor(WORKERS) as pool:
        found = list(pool.map(lambda name: list(_of_reader(seeds, name, each)), names))
    return each * len(names), [failure for failures in found for failure in failures]


def _of_reader(seeds: Path, name: str, each: int) -> Iterator[Failure]:
    first = 0
    while first < each:
        command = [
            sys.executable,
            "-m",
            "tests.benchmarks.attack.worker",
            str(seeds),
            name,
            str(first),
            str(each),
        ]
        done = subprocess.run(command, capture_output=True, text=True, timeout=MOST_SECONDS)
        lines = [_parsed(line) for line in done.stdout.splitlines()]
        begun = [line["begins"] for line in lines if "begins" in line]
        for line in lines:
            if "error" in line:
                said = f"{line['error']}: {line['said']} ({line['in']}, from {line['from']})"
                yield Failure(name, line["number"], said)
        words = [line for line in done.stderr.splitlines() if line.strip()]
        if done.returncode == 0:
            return
        last = begun[-1] if begun else first
        yield Failure(name, last, f"ended with {done.returncode}: {words[-1][:200] if words else 'no word'}")
        first = last + 1


def _parsed(line: str) -> dict[str, Any]:
    try:
        told = json.loads(line)
    except ValueError:
        return {}
    return told if isinstance(told, dict) else {}
