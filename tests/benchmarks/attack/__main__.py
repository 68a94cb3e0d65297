"""`python -m tests.benchmarks.attack [--short] [--parts NAME ...]`: figures; exit code 1 for any failure."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from tests.benchmarks.attack.damaged_files import read_damaged
from tests.benchmarks.attack.failure import Attack, Failure
from tests.benchmarks.attack.full_disk import attack_full_disks
from tests.benchmarks.attack.kills import attack_kills, attack_signals
from tests.benchmarks.attack.recordings import attack_recordings
from tests.benchmarks.attack.seeds import make_seeds
from tests.benchmarks.attack.sessions import attack_sessions
from tests.benchmarks.attack.starts import attack_starts
from tests.benchmarks.attack.window_kills import attack_window
from tests.heeding import heed_signals


@dataclass(frozen=True)
class Part:
    """One kind of attack."""

    attack: Attack
    short: int
    """0: the short form goes without."""
    long: int
    what: str
    """Is counted."""


PARTS = {
    "files": Part(read_damaged, 2, 250, "damaged files"),
    "sessions": Part(attack_sessions, 3, 500, "damaged sessions in a window"),
    "kills": Part(attack_kills, 1, 100, "commands killed at random moments"),
    "signals": Part(attack_signals, 0, 99, "commands ended by SIGINT, SIGTERM and SIGHUP"),
    "disks": Part(attack_full_disks, 1, 88, "commands on disks that fill up"),
    "starts": Part(attack_starts, 1, 160, "starts with damaged settings"),
    "recordings": Part(attack_recordings, 1, 20, "live recordings killed at random moments"),
    "window": Part(attack_window, 1, 70, "windows killed or ended at their work"),
}


def main() -> int:
    """Prints what was attacked, and each failure once with how often it came."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--parts", nargs="+", choices=[*PARTS], default=[*PARTS])
    parser.add_argument("--count", type=int, help="of each part; of files, of each reader")
    parser.add_argument("--only", nargs="*", default=(), help="readers of files")
    parser.add_argument("--seeds", type=Path)
    given = parser.parse_args()
    parts = PARTS | {"files": replace(PARTS["files"], attack=partial(read_damaged, only=tuple(given.only)))}
    failed = False
    heed_signals()
    with tempfile.TemporaryDirectory() as scratch:
        seeds = given.seeds or Path(scratch) / "seeds"
        if not seeds.exists():
            make_seeds(seeds)
        for name in given.parts:
            part, began = parts[name], time.perf_counter()
            count = given.count or (part.short if given.short else part.long)
            if not count:
                continue
            count, failures = part.attack(seeds, count)
            seconds = time.perf_counter() - began
            print(f"{count} {part.what}, {len(failures)} failures, {seconds:.0f} s", flush=True)
            tell(failures)
            failed = failed or bool(failures)
    return int(failed)


def tell(failures: Sequence[Failure]) -> None:
    """Each once, the most frequent first."""
    for (reader, error), times in Counter((one.reader, one.error) for one in failures).most_common():
        first = min(one.number for one in failures if (one.reader, one.error) == (reader, error))
        print(f"{times:4d} {reader} (first: {first}): {error}")


if __name__ == "__main__":
    sys.exit(main())
