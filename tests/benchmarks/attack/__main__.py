"""`python -m tests.benchmarks.attack [--short] [--each N]`: figures, and exit code 1 for any failure."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from tests.benchmarks.attack.damaged_files import Failure, read_damaged
from tests.benchmarks.attack.seeds import make_seeds

SHORT, LONG = 8, 250
"""Damaged files of each reader."""


def main() -> int:
    """Prints what was attacked, and each failure once with how often it came."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--each", type=int)
    parser.add_argument("--only", nargs="*", default=())
    parser.add_argument("--seeds", type=Path)
    given = parser.parse_args()
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as scratch:
        seeds = given.seeds or Path(scratch) / "seeds"
        if not seeds.exists():
            make_seeds(seeds)
        each = given.each or (SHORT if given.short else LONG)
        count, failures = read_damaged(seeds, each, tuple(given.only))
    print(f"{count} damaged files, {len(failures)} failures, {time.perf_counter() - began:.0f} s")
    for (reader, error), times in Counter((one.reader, one.error) for one in failures).most_common():
        print(f"{times:4d} {reader} (first: {_first(failures, reader, error)}): {error}")
    return int(bool(failures))


def _first(failures: list[Failure], reader: str, error: str) -> int:
    return min(one.number for one in failures if (one.reader, one.error) == (reader, error))


if __name__ == "__main__":
    sys.exit(main())
